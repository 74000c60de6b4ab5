#include "stiction/encounter.hpp"

#include <cmath>

namespace stiction {

Radii radii(const Encounter& encounter) {
  return std::visit([](const auto& one) { return Radii{one.radius, one.radius}; }, encounter);
}

std::optional<SpherePair> sphere_pair(const Asperity& upper, const Asperity& lower, double gap, Curvature allowed) {
  const bool both_convex = upper.radius > 0.0 && lower.radius > 0.0;
  if (!both_convex &&
      (allowed == Curvature::convex || !(upper.radius + lower.radius < 0.0) || upper.radius * lower.radius >= 0.0)) {
    return std::nullopt;
  }
  const double radius = upper.radius * lower.radius / (upper.radius + lower.radius);
  if (!std::isfinite(radius)) {
    return std::nullopt;
  }
  const bool lower_is_smaller = std::abs(lower.radius) <= std::abs(upper.radius);
  const Asperity& smaller = lower_is_smaller ? lower : upper;
  return SpherePair{upper.centre_offset() - lower.centre_offset(),
                    gap,
                    std::abs(upper.radius + lower.radius),
                    both_convex ? 1.0 : -1.0,
                    upper.radius * lower.radius * (upper.normal + lower.normal).squaredNorm(),
                    radius,
                    smaller.centre_offset(),
                    smaller.radius,
                    lower_is_smaller};
}

std::optional<SphereOnStraight> sphere_on_straight(const Asperity& sphere, Side side_of_sphere,
                                                   const Asperity& straight, double gap) {
  if (!(sphere.radius > 0.0) || !std::isfinite(sphere.radius)) {
    return std::nullopt;
  }
  const bool below = side_of_sphere == Side::lower;
  return SphereOnStraight{below ? Vector3(-straight.normal) : straight.normal, sphere.centre_offset(), below, gap,
                          sphere.radius};
}

}  // namespace stiction
