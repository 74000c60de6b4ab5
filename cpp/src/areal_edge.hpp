// Fractions of the area of a contact ellipse, and of its force, that lie inside the map.
#pragma once

#include "stiction/areal.hpp"

#include <array>
#include <cstddef>

namespace stiction {

struct InsideFractions {
  double force;
  double area;
};

// Edges of the map, in coordinates in which the contact ellipse at an overlap of 1 µm is the unit circle.
// In these coordinates, the map is a parallelogram.
class MapEdges {
 public:
  MapEdges(const ArealCandidates& candidates, const ArealCandidate& candidate);

  InsideFractions fractions_inside(double overlap) const;

 private:
  std::array<double, 4> distance_;  // distance of each side of the parallelogram from the centre of the unit circle
  std::array<std::array<double, 2>, 4>
      // Tangents of the angles from a side's normal to the lines between the circle's centre and the ends of the side.
      corners_;
};

}  // namespace stiction
