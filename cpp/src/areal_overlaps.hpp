// Contact ellipses projected onto the horizontal plane, and their overlaps.
#pragma once

#include "stiction/areal.hpp"

#include <cstddef>
#include <vector>

namespace stiction {

// Matrix S of a contact ellipse {x : xᵀ S⁻¹ x <= 1}, projected onto the horizontal plane, at an overlap of 1 µm.
struct ProjectedEllipse {
  double xx;
  double xy;
  double yy;
};

ProjectedEllipse projected_ellipse(const ArealCandidate& candidate);

std::size_t first_contact_step(const ArealCandidate& candidate, Values approaches);

// Return, for each candidate, the index of the first approach at which its ellipse overlaps another ellipse.
// If the ellipse of a candidate never overlaps another ellipse, the index is approaches.size().
std::vector<std::size_t> first_overlaps(const std::vector<ArealCandidate>& all, Values approaches,
                                        const CancellationCheck& check_cancellation);

}  // namespace stiction
