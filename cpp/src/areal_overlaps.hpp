// Ellipses of contact seen from above, and which of them overlap.
#pragma once

#include "stiction/areal.hpp"

#include <cstddef>
#include <vector>

namespace stiction {

// The shape {x : xᵀ S⁻¹ x <= 1} of an ellipse of unit overlap, seen from above.
struct Shape {
  double xx;
  double xy;
  double yy;
};

Shape shape_of(const ArealCandidate& candidate);

// The first of the approaches at which a candidate is a contact.
std::size_t first_step(const ArealCandidate& candidate, Values approaches);

// For each candidate, the first of the approaches at which its ellipse overlaps another: as many as there are for none.
std::vector<std::size_t> first_overlaps(const std::vector<ArealCandidate>& all, Values approaches,
                                        const Checkpoint& checkpoint);

}  // namespace stiction
