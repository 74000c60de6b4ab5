// Types of matrices and vectors: double precision, row-major order. The file values.hpp lists the units.
//
// In functions compiled into the library, no argument, result or variable is an Eigen array that owns its memory.
// Flags such as -mavx change how Eigen allocates memory, but the linker keeps one version of each Eigen function.
// Code compiled with other flags could therefore free an Eigen array by a function that does not match its allocation.
#pragma once

#include "stiction/values.hpp"

#include <Eigen/Core>

#include <type_traits>

namespace stiction {

static_assert(std::is_same_v<Index, Eigen::Index>, "EIGEN_DEFAULT_DENSE_INDEX_TYPE must not be changed");

using Vector2 = Eigen::Vector2d;  ///< horizontal vector (x, y)
using Vector3 = Eigen::Vector3d;  ///< vector (x, y, z)
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using MatrixView = Eigen::Ref<const Matrix>;

}  // namespace stiction
