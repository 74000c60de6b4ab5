// Contact ellipses projected onto the horizontal plane, and their overlaps.
#pragma once

#include "stiction/areal.hpp"

#include <cstddef>
#include <vector>

namespace stiction {

// Matrix S that describes the projected contact ellipse {x : xᵀ S⁻¹ x <= 1} at unit overlap.
struct ProjectedEllipse {
  double xx;
  double xy;
  double yy;
};

ProjectedEllipse projected_ellipse(const ArealCandidate& candidate);

std::size_t first_contact_step(const ArealCandidate& candidate, Values approaches);

// Return, for each candidate, the index of the first approach with an overlap, or approaches.size() if there is none.
std::vector<std::size_t> first_overlaps(const std::vector<ArealCandidate>& all, Values approaches,
                                        const CancellationCheck& check_cancellation);

}  // namespace stiction
