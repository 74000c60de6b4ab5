// Interpolation of height maps by the tensor product of natural cubic splines along x and y.
#pragma once

#include "stiction/array.hpp"

namespace stiction {

/// Minimum number of rows of a map, and minimum number of columns.
/// A natural cubic spline needs two inner points, because its curvature is zero at both end points.
constexpr Index min_map_points = 4;

/// Replace heights [µm] by the coefficients [µm] of the B-spline that interpolates the heights.
/// On entry, the inner elements of `coefficients` contain the heights. The outermost rows and columns are only written.
/// The coefficients have a round-off of about 1e-16 of the largest height.
/// Throws std::invalid_argument for fewer than 4 by 4 heights.
void natural_bicubic(Eigen::Ref<Matrix> coefficients);

/// Compute slopes at every point of a map from natural cubic splines along the rows (x).
/// If there are several rows, slopes along the columns (y) are computed too. `spacing` is (Δx, Δy) [µm].
/// Throws std::invalid_argument if a row has fewer than two points.
void natural_slopes(const MatrixView& heights, const Vector2& spacing, Eigen::Ref<Matrix> along_x,
                    Eigen::Ref<Matrix> along_y);

/// Value and derivatives of a spline at a point.
/// The derivatives of the spline are taken with respect to x and y, both in units of the grid spacing.
struct Jet {
  double value;  ///< value of the spline [µm]
  double x;
  double y;
  double xx;
  double xy;
  double yy;
};

/// Evaluate the spline in the cell between rows `row`, `row + 1` and columns `column`, `column + 1`.
/// `u` and `v` are the positions in the cell along x and y, in units of the grid spacing.
/// If u or v lies slightly outside [0, 1], the polynomial of the cell is extrapolated.
Jet bicubic_at(const MatrixView& coefficients, Index row, Index column, double u, double v);

}  // namespace stiction
