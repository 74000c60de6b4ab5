// Vectorised passes over two profiles that select the few points at which contact is possible.
// All heights [µm] must be finite, and both profiles must have the same number of points.
#pragma once

#include "stiction/values.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

namespace stiction {

/// Smallest gap on the whole grid, and smallest gap in each block of grid points.
/// A block of grid points contains no contact if its smallest gap exceeds the approach.
struct Prefilter {
  static constexpr std::size_t block = 64;

  double min_gap = std::numeric_limits<double>::infinity();
  std::vector<double> block_min_gap;  ///< smallest upper minus lower height [µm] in each `block` of points
  bool upper_finite = true;
  bool lower_finite = true;
  double upper_max_abs = 0.0;  ///< largest |height| of the profile [µm]
  double lower_max_abs = 0.0;

  /// Add the next chunk of heights [µm]. Every chunk except the last must consist of whole blocks.
  void add(Values upper, Values lower);
};

Prefilter run_prefilter(Values upper, Values lower);

struct IndexRange {
  std::size_t begin;
  std::size_t end;
};

/// Return ranges of grid indices that contain every grid point whose gap at zero approach is at most `max_gap` [µm].
std::vector<IndexRange> ranges_within(Values upper, Values lower, const Prefilter& prefilter, double max_gap);

/// Return an upper bound [µm] of the distance by which the spline of the gap dips below the smallest gap on the grid.
/// The bound is 3/8 D, where D is the largest |second difference| of the gap values at three successive points.
/// A natural spline f has |f''| <= 3 D/Δx², and dips by at most Δx²/8 max |f''| between two grid points.
double max_dip(Values upper, Values lower);

/// Return whether a profile is straight to within the round-off of heights up to `max_abs`, its largest |height| [µm].
bool is_straight(Values heights, double max_abs);

struct Derivatives {
  const double* upper_slope;
  const double* upper_curvature;
  const double* lower_slope;
  const double* lower_curvature;
};

/// Mark all grid points at which contact is possible for some approach up to `max_approach` [µm].
/// Some grid points at which no contact is possible may also be marked.
/// Contact is possible where both profiles are convex and the contact centre passes through the cell of the point.
/// `zero` [µm] is the smallest height difference (upper - lower) on the grid. Gaps are height differences minus `zero`.
void mark_cells(Derivatives derivatives, const double* upper, const double* lower, std::size_t size, double zero,
                double max_approach, double half_cell, unsigned char* marks);

/// Mark intervals [x_i, x_(i+1)) in which the signs of slope and curvature at both ends allow a minimum of the gap.
/// `size` intervals have size + 1 ends, so `derivatives` must contain size + 1 elements.
void mark_minima(Derivatives derivatives, std::size_t size, unsigned char* marks);

/// Return the position [µm] of a local minimum of the spline of the gap in the interval from 0 to `spacing`, if any.
/// A minimum at a grid point belongs to the interval on its right. The first point of a profile is never a minimum.
std::optional<double> gap_minimum(double slope, double curvature, double next_slope, double next_curvature,
                                  double spacing, bool at_first_point = false);

inline std::optional<double> gap_minimum(double slope, double curvature, double next_slope, double next_curvature,
                                         double spacing, bool at_first_point) {
  if (slope == 0.0 && curvature > 0.0 && !at_first_point) {
    return 0.0;
  }
  // At the distance t from the left end of the interval, the slope of the gap is slope + curvature t + half_rate t².
  const double half_rate = (next_curvature - curvature) / (2.0 * spacing);
  const double discriminant = curvature * curvature - 4.0 * half_rate * slope;
  if (!(discriminant > 0.0)) {
    return std::nullopt;
  }
  const double root = std::sqrt(discriminant);
  // The sign of the curvature selects the form of the quadratic formula that avoids cancellation.
  const double t = curvature >= 0.0 ? -2.0 * slope / (curvature + root) : (root - curvature) / (2.0 * half_rate);
  if (slope < 0.0 && next_slope > 0.0) {
    // If the slope changes from negative to positive, only round-off can move t outside the interval.
    return std::clamp(t, 0.0, spacing);
  }
  return t > 0.0 && t < spacing ? std::optional(t) : std::nullopt;
}

}  // namespace stiction
