// Part of a contact ellipse that lies inside the map.
#pragma once

#include "stiction/areal.hpp"

#include <array>
#include <cstddef>

namespace stiction {

struct InsideFractions {
  double force;
  double area;
};

// The map is a parallelogram in the coordinates in which the contact ellipse at unit overlap is the unit circle.
class MapEdges {
 public:
  MapEdges(const ArealCandidates& candidates, const ArealCandidate& candidate);

  InsideFractions fractions_inside(double overlap) const;

 private:
  std::array<double, 4> distance_;  // distance of each side of the parallelogram from the centre of the unit circle
  std::array<std::array<double, 2>, 4>
      // Directions from the circle's centre to both ends of a side, as tangents of their angles to the side's normal.
      corners_;
};

}  // namespace stiction
