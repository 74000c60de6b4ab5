// Natural cubic spline through equally spaced points: slope and curvature at the points themselves.
#pragma once

#include "stiction/array.hpp"

namespace stiction {

/// Slope f' [-] and curvature f'' [1/µm] at every point of the natural cubic spline through `heights` [µm].
/// At least 4 heights; spacing [µm] > 0; the outputs have as many elements as `heights`. At both ends f'' = 0.
/// The spline's tridiagonal system is solved by GSL. Throws std::invalid_argument, std::runtime_error (GSL).
void natural_spline(Values heights, double spacing, std::span<double> slope, std::span<double> curvature);

/// A natural spline forgets a point by a factor 2 - sqrt(3) = 0.268 per point, so a spline through a window gives the
/// derivatives of the whole-profile spline, bit for bit in all but the rarest rounding, this many points inside it.
inline constexpr Index spline_reach = 48;

}  // namespace stiction
