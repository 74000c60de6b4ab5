#include "areal_edge.hpp"

#include "areal_overlaps.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace stiction {

Edges::Edges(const ArealCandidates& found, const ArealCandidate& candidate) : distance_{}, corners_{} {
  const Shape shape = shape_of(candidate);
  const double wide = std::sqrt(shape.xx);
  const double high = std::sqrt(shape.yy);
  const double width = found.spacing.x() * static_cast<double>(found.columns - 1);
  const double height = found.spacing.y() * static_cast<double>(found.rows - 1);
  const double x = candidate.position.x();
  const double y = candidate.position.y();
  distance_ = {(width - x) / wide, (height - y) / high, x / wide, y / high};  // counter-clockwise
  const double cosine = shape.xy / (wide * high);
  const double sine =
      std::sqrt(candidate.ellipse.major) * std::sqrt(candidate.ellipse.minor) * candidate.normal.z() / (wide * high);
  for (std::size_t i = 0; i < 4; ++i) {
    // The angles between the sides' normals are alternately that of the cosine and what it lacks to a half turn.
    const double to_next = i % 2 == 0 ? cosine : -cosine;
    const double next = distance_[(i + 1) % 4] - distance_[i] * to_next;
    const double previous = distance_[(i + 3) % 4] + distance_[i] * to_next;
    corners_[i] = {-previous / (distance_[i] * sine), next / (distance_[i] * sine)};
  }
}

// With h the distance of a side from the centre of the unit circle, the rays between the angles φ₁ and φ₂ hold inside
// of it (1/2π) ∫ h²/cos²φ dφ of the area, and (1/2π) ∫ 1 - (1 - h²/cos²φ)^(3/2) dφ of the force, whose pressure goes as
// (1 - r²)^(1/2); where the circle is nearer, beyond |tan φ| = (1 - h²)^(1/2)/h, the share of the angle. In closed form
// and so that nothing cancels where the map is a small part of the ellipse; one side leaves (2 + 3 h - h³)/4 of the
// force.
Inside Edges::inside(double overlap) const {
  Inside share{0.0, 0.0};
  const double radius = std::sqrt(overlap);
  for (std::size_t i = 0; i < 4; ++i) {
    const double h = distance_[i] / radius;
    const double square = (1.0 - h) * (1.0 + h);
    const double end = h < 1.0 ? std::sqrt(square) / h : 0.0;
    for (std::size_t side = 0; side < 2; ++side) {
      const double tangent = std::clamp(corners_[i][side], -end, end);
      const double sign = side == 0 ? -1.0 : 1.0;
      const double of_circle = std::atan(corners_[i][side]) - std::atan(tangent);
      double force = of_circle;
      double area = of_circle;
      if (h < 1.0) {
        const double rest = std::sqrt(std::max(0.0, square - h * h * tangent * tangent));
        force += std::atan2(-h * h * tangent * (1.0 + tangent * tangent) / (1.0 + rest), rest + tangent * tangent) +
                 0.5 * h * (3.0 - h * h) * std::atan2(h * tangent, rest) + 0.5 * h * h * tangent * rest;
        area += h * h * tangent;
      }
      share.force += sign * force;
      share.area += sign * area;
    }
  }
  constexpr double turn = 2.0 * std::numbers::pi;
  return {share.force / turn, share.area / turn};
}

}  // namespace stiction
