// Numbers and arrays as the whole library uses them: double precision, row-major, signed indices.
//
// Units everywhere: lengths µm, forces mN, pressures GPa (1 GPa = 1 mN/µm², so no factor appears).
//
// No compiled function hands over an Eigen array that owns its memory: how Eigen allocates depends on compiler flags
// (-mavx, -fsanitize=address), which a program and the library need not share.
#pragma once

#include <Eigen/Core>

#include <span>

namespace stiction {

using Index = Eigen::Index;
using Vector2 = Eigen::Vector2d;
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using MatrixView = Eigen::Ref<const Matrix>;

/// Heights [µm] of a profile, or any other run of values on its grid.
using Values = std::span<const double>;

}  // namespace stiction
