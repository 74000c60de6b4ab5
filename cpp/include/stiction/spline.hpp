// Natural cubic spline through equally spaced points: slope and curvature at all points or in a range of points.
#pragma once

#include "stiction/values.hpp"

namespace stiction {

/// Compute slope f' [-] and curvature f'' [1/µm] at every point of the natural cubic spline through `heights` [µm].
/// At least 4 heights are required, and the spacing [µm] must be positive.
/// `slope` and `curvature` must have as many elements as `heights`. At both ends of the profile, f'' = 0.
/// Throws std::invalid_argument for invalid arguments, and std::runtime_error for errors of GSL.
void natural_spline(Values heights, double spacing, std::span<double> slope, std::span<double> curvature);

/// Compute slope and curvature of the natural cubic spline only at the points first, first + 1, ...
/// The size of the output arrays determines the number of points.
/// The spline is a superposition of unit splines. Each unit spline is due to a load at a single point.
/// Each unit spline decays by a factor of 2 - sqrt(3) = 0.268 per point, so only nearby points contribute.
/// Throws the same exceptions as natural_spline. Also throws std::invalid_argument if a point lies beyond the profile.
void natural_spline_from(Values heights, double spacing, Index first, std::span<double> slope,
                         std::span<double> curvature);

}  // namespace stiction
