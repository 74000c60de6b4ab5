// Where two profiles may touch: passes over their points, wide and cheap, so that few places are left to look at one by
// one. Heights [µm] of both are finite and equally many.
#pragma once

#include "stiction/array.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

namespace stiction {

/// One pass over a pair: its first touch, and what shows which parts of it ever come near.
struct Screening {
  static constexpr std::size_t block = 64;

  double gap = std::numeric_limits<double>::infinity();  ///< lowest upper less lower height on the grid [µm]
  std::vector<double> block_gap;                         ///< the lowest of each `block` points [µm]
  bool upper_finite = true;                              ///< no height is NaN or infinite
  bool lower_finite = true;
  double upper_largest = 0.0;  ///< of |height| [µm]
  double lower_largest = 0.0;

  /// The next points of both bodies, a whole number of blocks unless they are the last.
  void add(Values upper, Values lower);
};

Screening screen(Values upper, Values lower);

/// Points from `begin` to before `end`.
struct Stretch {
  std::size_t begin;
  std::size_t end;
};

/// Stretches of the grid, in its order, that hold all points whose gap above first touch is at most `largest` [µm].
std::vector<Stretch> stretches_within(Values upper, Values lower, const Screening& screening, double largest);

/// How far the splined gap may dip below its values on the grid [µm]: 3/8 of its largest second difference, because
/// |f''| of a natural spline is at most 3 of them per Δx², and a cubic dips below its ends by at most |f''| Δx² / 8.
double largest_dip(Values upper, Values lower);

/// Whether the points of a profile lie on a line, to the round-off of the largest height [µm]: such a body has no
/// radius.
bool is_straight(Values heights, double largest);

/// Slopes [-] and curvatures [1/µm] of both bodies at consecutive points.
struct Derivatives {
  const double* upper_slope;
  const double* upper_curvature;
  const double* lower_slope;
  const double* lower_curvature;
};

/// Marks points at which both bodies are convex and the contact centre passes through the cell between first touch and
/// the largest approach [µm]; some more, but none fewer. The centre moves one way as the distance of the sphere centres
/// shrinks, so its two ends tell. `zero` is the gap at first touch [µm].
void mark_cells(Derivatives at, const double* upper, const double* lower, std::size_t size, double zero, double largest,
                double half_cell, unsigned char* marks);

/// Marks intervals [x_i, x_(i+1)) in which the splined gap may have a minimum, by the signs at their ends; derivatives
/// of one more point than intervals.
void mark_minima(Derivatives at, std::size_t size, unsigned char* marks);

/// The local minimum of the splined gap in an interval [0, spacing) [µm], if there is one, by the slopes [-] and
/// curvatures [1/µm] of the gap at its ends: the root of the slope, a quadratic there, at which the gap is convex. A
/// minimum on a point belongs to the interval on its right, and none is at the first point of a profile.
std::optional<double> gap_minimum(double slope, double curvature, double next_slope, double next_curvature,
                                  double spacing, bool at_first_point = false);

// ---- The kernel, inline because there are many of it ----------------------------------------------------------------

inline std::optional<double> gap_minimum(double slope, double curvature, double next_slope, double next_curvature,
                                         double spacing, bool at_first_point) {
  if (slope == 0.0 && curvature > 0.0 && !at_first_point) {
    return 0.0;
  }
  // slope + curvature t + half_rate t²
  const double half_rate = (next_curvature - curvature) / (2.0 * spacing);
  const double discriminant = curvature * curvature - 4.0 * half_rate * slope;
  if (!(discriminant > 0.0)) {
    return std::nullopt;
  }
  const double root = std::sqrt(discriminant);
  // The root at which the quadratic rises, in the form that does not cancel.
  const double t = curvature >= 0.0 ? -2.0 * slope / (curvature + root) : (root - curvature) / (2.0 * half_rate);
  if (slope < 0.0 && next_slope > 0.0) {
    return std::clamp(t, 0.0, spacing);  // it is there, whatever round-off says
  }
  return t > 0.0 && t < spacing ? std::optional(t) : std::nullopt;
}

}  // namespace stiction
