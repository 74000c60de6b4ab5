// Part of a contact ellipse that lies inside the map.
#pragma once

#include "stiction/areal.hpp"

#include <array>
#include <cstddef>

namespace stiction {

// Fractions of the force and of the area of a contact that lie inside the map.
struct InsideFractions {
  double force;
  double area;
};

// The four edges of the map, as sides of a parallelogram around the unit circle.
// In the coordinates of the parallelogram, the contact ellipse at unit overlap is the unit circle.
class MapEdges {
 public:
  MapEdges(const ArealCandidates& candidates, const ArealCandidate& candidate);

  // Compute the fractions of a Hertzian contact with the given overlap [µm] that lie inside the map.
  InsideFractions fractions_inside(double overlap) const;

 private:
  std::array<double, 4> distance_;  // distance of each side from the centre
  std::array<std::array<double, 2>, 4>
      // Tangents of the angles at both ends of each side of the parallelogram, measured from the normal of the side.
      corners_;
};

}  // namespace stiction
