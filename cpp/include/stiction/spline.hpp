// Natural cubic spline through equally spaced points: slope and curvature at the points themselves, at all or at some.
#pragma once

#include "stiction/array.hpp"

namespace stiction {

/// Slope f' [-] and curvature f'' [1/µm] at every point of the natural cubic spline through `heights` [µm].
/// At least 4 heights; spacing [µm] > 0; the outputs have as many elements as `heights`. At both ends f'' = 0.
/// The spline's tridiagonal system is solved by GSL. Throws std::invalid_argument, std::runtime_error (GSL).
void natural_spline(Values heights, double spacing, std::span<double> slope, std::span<double> curvature);

/// The same of some of its points alone: first, first + 1, ..., as many as the outputs have elements. A superposition
/// of GSL's spline of a unit load at one point, which decays by 2 - sqrt(3) = 0.268 a point, so that only near points
/// count. Throws as above, and where the points lie beyond the profile.
void natural_spline_from(Values heights, double spacing, Index first, std::span<double> slope,
                         std::span<double> curvature);

}  // namespace stiction
