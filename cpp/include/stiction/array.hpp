// Number and array types of the library: double precision, row-major, signed indices.
//
// Units: lengths in µm, forces in mN, pressures in GPa. 1 GPa = 1 mN/µm², so no conversion factors appear. Height is z.
// A profile lies along x, at y = 0.
//
// No compiled function takes, returns or contains an Eigen array that owns its memory.
// How Eigen allocates and aligns memory depends on compiler flags (-mavx, -fsanitize=address).
// The linker keeps one version of each Eigen function, even if program and library were compiled with different flags.
// An Eigen array could therefore be freed by a function that does not match the function that allocated the array.
#pragma once

#include <Eigen/Core>

#include <span>

namespace stiction {

using Index = Eigen::Index;
using Vector2 = Eigen::Vector2d;  ///< horizontal vector (x, y)
using Vector3 = Eigen::Vector3d;  ///< vector (x, y, z)
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using MatrixView = Eigen::Ref<const Matrix>;

/// Heights [µm] of a profile, or other values at the grid points of a profile.
using Values = std::span<const double>;

}  // namespace stiction
