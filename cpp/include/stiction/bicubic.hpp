// Interpolation of height maps by the tensor product of natural cubic splines along x and y.
#pragma once

#include "stiction/array.hpp"

namespace stiction {

/// A natural cubic spline needs two inner points along each axis, because its curvature is zero at both end points.
constexpr Index min_map_points = 4;

/// Replace heights [µm], at least 4 by 4, by the coefficients [µm] of the B-spline that interpolates the heights.
/// On entry, `coefficients` contains the heights, except in its first and last row and column, which are only written.
void natural_bicubic(Eigen::Ref<Matrix> coefficients);

/// Compute slopes of a map along its rows (x) and, if it has several rows, along its columns (y).
/// `spacing` is (Δx, Δy) [µm].
void natural_slopes(const MatrixView& heights, const Vector2& spacing, Eigen::Ref<Matrix> along_x,
                    Eigen::Ref<Matrix> along_y);

/// Value [µm] of a spline, and its derivatives [µm] with respect to x and y, both in units of the grid spacing.
struct Jet {
  double value;
  double x;
  double y;
  double xx;
  double xy;
  double yy;
};

/// Evaluate the spline in the cell (`row`, `column`) at `u` along x and `v` along y, in units of the grid spacing.
/// If u or v lies slightly outside [0, 1], the polynomial of the cell is extrapolated.
Jet bicubic_at(const MatrixView& coefficients, Index row, Index column, double u, double v);

}  // namespace stiction
