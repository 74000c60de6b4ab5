// What of an ellipse of contact lies inside of the map.
#pragma once

#include "stiction/areal.hpp"

#include <array>
#include <cstddef>

namespace stiction {

// Shares of a contact that lie inside.
struct Inside {
  double force;
  double area;
};

// The four edges of the map as a contact sees them: in coordinates in which its ellipse of unit overlap is the unit
// circle, they are the sides of a parallelogram around it.
class Edges {
 public:
  Edges(const ArealCandidates& found, const ArealCandidate& candidate);

  // Of the ellipse of this overlap [µm], whose pressure is that of Hertz.
  Inside inside(double overlap) const;

 private:
  std::array<double, 4> distance_;                // of the sides from the centre
  std::array<std::array<double, 2>, 4> corners_;  // tangents of the angles at which they end, from where they are near
};

}  // namespace stiction
