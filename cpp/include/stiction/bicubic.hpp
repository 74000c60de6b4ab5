// The surface between the points of a map: the tensor product of natural cubic splines along x and y.
#pragma once

#include "stiction/array.hpp"

namespace stiction {

/// Fewest rows and columns of a map: a natural cubic spline with a curvature of its own needs two inner points.
constexpr Index fewest_points = 4;

/// Replaces heights [µm] by the B-spline coefficients [µm] of their spline. The heights are the inner values of the
/// array, at least 4 by 4; the outermost rows and columns are written only. Round-off is some 1e-16 of the largest
/// height. Throws std::invalid_argument.
void natural_bicubic(Eigen::Ref<Matrix> coefficients);

/// Slopes at every point of a map of natural cubic splines along its rows (x), and along its columns (y) if there are
/// several. `spacing` is of columns and of rows [µm]. Throws std::invalid_argument for less than two points along a
/// line.
void natural_slopes(const MatrixView& heights, const Vector2& spacing, Eigen::Ref<Matrix> along_x,
                    Eigen::Ref<Matrix> along_y);

/// Value and derivatives of a spline at a point, by x and y in units of the spacings.
struct Jet {
  double value;  ///< [µm]
  double x;
  double y;
  double xx;
  double xy;
  double yy;
};

/// The spline in the cell between rows `row`, `row + 1` and columns `column`, `column + 1`, at the fractions u along x
/// and v along y of it, which may lie somewhat outside of [0, 1]: there it is the cell's own polynomial.
Jet bicubic_at(const MatrixView& coefficients, Index row, Index column, double u, double v);

}  // namespace stiction
