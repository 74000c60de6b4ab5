// Contact candidates of two profiles: the points where the profiles may touch, for any contact law.
//
// The approach is the displacement of the upper surface towards the lower since the first contact of grid points.
// A profile that is straight to within round-off counts as a flat with the normal of the straight line.
#pragma once

#include "stiction/array.hpp"
#include "stiction/asperity_pair.hpp"
#include "stiction/cancellation.hpp"
#include "stiction/detection.hpp"

#include <functional>
#include <string_view>
#include <vector>

namespace stiction {

/// With the detection method `cell`, a contact centre must lie within half a grid spacing of its grid point (Eq. 5).
/// With `gap_minimum`, candidates are local minima of the spline of the gap, and are the same at all approaches.
enum class Detection { cell, gap_minimum };

/// Return the detection method named "cell" or "gap-minimum", or the curvature rule named "convex" or "signed".
Detection detection(std::string_view name);
Curvature curvature(std::string_view name);

struct ProfilePair {
  Values upper;
  Values lower;
  double spacing;
};

/// Two asperities that touch if the approach is at least `gap` and `classify` returns `ContactClass::contact`.
struct Candidate {
  /// Index of the grid point at the candidate or, with `gap_minimum`, of the grid point to the left of the minimum.
  Index index;
  /// Position of the candidate [µm] on the lower surface, in the coordinates of the lower profile.
  Vector3 position;
  /// Gap [µm] at zero approach; negative at a minimum between grid points that is below the gap at all grid points.
  double gap;
  Radii radii;
  AsperityPair asperity_pair;  ///< asperity pair, whose contact points are relative to `position`
};

/// Call `visit(candidate)`, from left to right, for every candidate with a gap of at most `deepest` (>= 0) [µm].
/// Detection::cell may omit a candidate whose contact centre is outside its cell at every approach up to `deepest`.
/// Throws std::invalid_argument unless both profiles have equally many finite heights (>= 4) and a positive spacing.
void for_each_candidate(const ProfilePair& pair, double deepest, Detection detection, Curvature curvature,
                        const std::function<void(const Candidate&)>& visit,
                        const CancellationCheck& check_cancellation = {});

Prefilter run_prefilter(const ProfilePair& pair);

void for_each_candidate(const ProfilePair& pair, const Prefilter& prefilter, double deepest, Detection detection,
                        Curvature curvature, const std::function<void(const Candidate&)>& visit,
                        const CancellationCheck& check_cancellation = {});

struct Candidates {
  std::vector<Candidate> all;
  double deepest;  ///< largest approach [µm] at which all contacts are candidates
  double spacing;
};

Candidates candidates(const ProfilePair& pair, double deepest, Curvature curvature,
                      const CancellationCheck& check_cancellation = {});

}  // namespace stiction
