#include "areal_edge.hpp"

#include "areal_overlaps.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace stiction {

MapEdges::MapEdges(const ArealCandidates& candidates, const ArealCandidate& candidate) : distance_{}, corners_{} {
  const ProjectedEllipse ellipse = projected_ellipse(candidate);
  const double half_width = std::sqrt(ellipse.xx);
  const double half_height = std::sqrt(ellipse.yy);
  const double width = candidates.spacing.x() * static_cast<double>(candidates.columns - 1);
  const double height = candidates.spacing.y() * static_cast<double>(candidates.rows - 1);
  const double x = candidate.position.x();
  const double y = candidate.position.y();
  distance_ = {(width - x) / half_width, (height - y) / half_height, x / half_width,
               y / half_height};  // sides in counter-clockwise order
  const double cosine = ellipse.xy / (half_width * half_height);
  const double sine = std::sqrt(candidate.ellipse.major) * std::sqrt(candidate.ellipse.minor) * candidate.normal.z() /
                      (half_width * half_height);
  for (std::size_t i = 0; i < 4; ++i) {
    // The cosine between the normals of successive sides changes its sign at each corner of the parallelogram.
    const double to_next = i % 2 == 0 ? cosine : -cosine;
    const double next = distance_[(i + 1) % 4] - distance_[i] * to_next;
    const double previous = distance_[(i + 3) % 4] + distance_[i] * to_next;
    corners_[i] = {-previous / (distance_[i] * sine), next / (distance_[i] * sine)};
  }
}

// Let h be the distance of a side of the parallelogram from the centre of the unit circle.
// The sector of the circle between the angles φ₁ and φ₂ adds (1/2π) ∫ h²/cos²φ dφ to the area fraction inside the map.
// For Hertzian pressure, the sector adds (1/2π) ∫ 1 - (1 - h²/cos²φ)^(3/2) dφ to the force fraction inside the map.
// At angles with |tan φ| > (1 - h²)^(1/2)/h, the side is outside the unit circle and cuts nothing off the circle.
// Both integrals are evaluated in closed forms that avoid cancellation if little of the ellipse lies inside the map.
InsideFractions MapEdges::fractions_inside(double overlap) const {
  InsideFractions sum{0.0, 0.0};
  const double radius = std::sqrt(overlap);
  for (std::size_t i = 0; i < 4; ++i) {
    const double h = distance_[i] / radius;
    const double square = (1.0 - h) * (1.0 + h);
    const double end = h < 1.0 ? std::sqrt(square) / h : 0.0;
    for (std::size_t side = 0; side < 2; ++side) {
      const double tangent = std::clamp(corners_[i][side], -end, end);
      const double sign = side == 0 ? -1.0 : 1.0;
      const double circle_angle = std::atan(corners_[i][side]) - std::atan(tangent);
      double force = circle_angle;
      double area = circle_angle;
      if (h < 1.0) {
        const double rest = std::sqrt(std::max(0.0, square - h * h * tangent * tangent));
        force += std::atan2(-h * h * tangent * (1.0 + tangent * tangent) / (1.0 + rest), rest + tangent * tangent) +
                 0.5 * h * (3.0 - h * h) * std::atan2(h * tangent, rest) + 0.5 * h * h * tangent * rest;
        area += h * h * tangent;
      }
      sum.force += sign * force;
      sum.area += sign * area;
    }
  }
  constexpr double full_turn = 2.0 * std::numbers::pi;
  return {sum.force / full_turn, sum.area / full_turn};
}

}  // namespace stiction
