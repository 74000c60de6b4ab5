// Places where two profiles may touch, before anything presses them together.
//
// Both profiles share one grid. The approach is the displacement of the upper body towards the lower one, measured from
// the first touch of grid points. A profile whose points lie on a line, to the round-off of their heights, is a convex
// body of infinite radius, with the line's normal.
#pragma once

#include "stiction/array.hpp"
#include "stiction/checkpoint.hpp"
#include "stiction/detection.hpp"
#include "stiction/encounter.hpp"

#include <functional>
#include <string_view>
#include <vector>

namespace stiction {

/// Where a contact is looked for.
/// cell (Eq. 5): at grid points, where the contact centre lies within half a spacing of the point.
/// gap_minimum: at the local minima of the splined gap, each found once for all approaches; does not depend on the grid
/// where the grid resolves the surfaces.
enum class Detection { cell, gap_minimum };

/// By the words of results: "cell", "gap-minimum"; "convex", "signed". Throws std::invalid_argument for another.
Detection detection(std::string_view word);
Curvature curvature(std::string_view word);

/// Two profiles [µm] on one grid of points `spacing` [µm] apart.
struct ProfilePair {
  Values upper;
  Values lower;
  double spacing;
};

/// A place where two asperities face each other. It touches at approaches of at least its gap, if the encounter says
/// so.
struct Candidate {
  Index index;          ///< grid point that owns it: its own (cell), or the one on its left (gap_minimum)
  Vector3 position;     ///< of the lower body there [µm], in the frame of the lower profile
  double gap;           ///< above first touch of grid points [µm]; a minimum between two of them may be below 0
  Radii radii;          ///< of the relative curvature
  Encounter encounter;  ///< positions of its touches are relative to `position`
};

/// Calls visit(candidate) for every candidate of a pair with a gap of at most `deepest` [µm] >= 0, from left to right.
/// By cell, candidates that cannot touch in their cell at any approach up to `deepest` may be left out.
/// Heights are finite, at least 4 and equally many; spacing [µm] > 0. Throws std::invalid_argument.
void for_each_candidate(const ProfilePair& pair, double deepest, Detection detection, Curvature curvature,
                        const std::function<void(const Candidate&)>& visit, const Checkpoint& checkpoint = {});

/// The first pass over a pair. Throws std::invalid_argument unless the profiles have equally many points.
Screening screen(const ProfilePair& pair);

/// The same of a pair that is screened already.
void for_each_candidate(const ProfilePair& pair, const Screening& screening, double deepest, Detection detection,
                        Curvature curvature, const std::function<void(const Candidate&)>& visit,
                        const Checkpoint& checkpoint = {});

/// Candidates found once, for any number of presses up to an approach of `deepest`.
struct Candidates {
  std::vector<Candidate> all;
  double deepest;  ///< [µm]
  double spacing;  ///< of the grid [µm]
};

/// Those by the gap minimum, of two profiles: what a candidate is there does not depend on the approach.
Candidates candidates(const ProfilePair& pair, double deepest, Curvature curvature, const Checkpoint& checkpoint = {});

}  // namespace stiction
