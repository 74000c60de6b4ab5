// Natural cubic spline through equally spaced points: slope and curvature at all points or in a range of points.
#pragma once

#include "stiction/values.hpp"

namespace stiction {

/// Compute slope f' [-] and curvature f'' [1/µm] at every point of the natural cubic spline through `heights` [µm].
/// `slope` and `curvature` must be as long as `heights`, at least 4. At both ends of the profile, f'' = 0.
void natural_spline(Values heights, double spacing, std::span<double> slope, std::span<double> curvature);

/// Compute slope and curvature of the spline at successive grid points, of which the first has the index `first`.
/// Only heights near these points are read: a height's influence decays by a factor of 2 - sqrt(3) = 0.268 per point.
/// Throws std::invalid_argument if a grid point at which a slope is requested lies beyond the end of the profile.
void natural_spline_from(Values heights, double spacing, Index first, std::span<double> slope,
                         std::span<double> curvature);

}  // namespace stiction
