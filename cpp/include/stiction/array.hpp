// Numbers and arrays as the whole library uses them: double precision, row-major, signed indices.
//
// Units everywhere: lengths µm, forces mN, pressures GPa (1 GPa = 1 mN/µm², so no factor appears). Height is z; a
// profile lies along x, at y = 0.
//
// No compiled function hands over or has inside an Eigen array that owns its memory: how Eigen allocates and aligns
// depends on compiler flags (-mavx, -fsanitize=address), which a program and the library need not share, and the linker
// takes one of the two instances of a template for both.
#pragma once

#include <Eigen/Core>

#include <span>

namespace stiction {

using Index = Eigen::Index;
using Vector2 = Eigen::Vector2d;  ///< (x, y): horizontal
using Vector3 = Eigen::Vector3d;  ///< (x, y, z)
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using MatrixView = Eigen::Ref<const Matrix>;

/// Heights [µm] of a profile, or any other run of values on its grid.
using Values = std::span<const double>;

}  // namespace stiction
