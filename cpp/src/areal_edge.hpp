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

// The four edges of the map in the coordinates of a contact.
// In these coordinates, the ellipse of unit overlap is the unit circle.
// The edges become the sides of a parallelogram around the circle.
class MapEdges {
 public:
  MapEdges(const ArealCandidates& candidates, const ArealCandidate& candidate);

  // Compute the fractions inside the map for the ellipse at this overlap [µm], with Hertzian pressure.
  InsideFractions fractions_inside(double overlap) const;

 private:
  std::array<double, 4> distance_;  // distances of the sides from the centre
  std::array<std::array<double, 2>, 4>
      // Tangents of the angles at which the sides end. The angles are measured from the normals of the sides.
      corners_;
};

}  // namespace stiction
