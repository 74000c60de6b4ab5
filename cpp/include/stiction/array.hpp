// Matrices and vectors of the library: double precision, row-major. Units: values.hpp.
//
// No compiled function of the library has an argument, result or variable that is an Eigen array with its own memory.
// Compiler flags such as -mavx and -fsanitize=address change how Eigen allocates and aligns memory.
// The linker keeps one version of each Eigen function, even if program and library were compiled with different flags.
// An Eigen array could therefore be freed by a function that does not match the function which allocated the array.
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
