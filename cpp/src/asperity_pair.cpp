#include "stiction/asperity_pair.hpp"

#include <cmath>

namespace stiction {

Radii radii(const AsperityPair& asperity_pair) {
  return std::visit([](const auto& pair) { return Radii{pair.radius, pair.radius}; }, asperity_pair);
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

std::optional<SphereOnFlat> sphere_on_flat(const Asperity& sphere, Side sphere_side, const Asperity& flat, double gap) {
  if (!(sphere.radius > 0.0) || !std::isfinite(sphere.radius)) {
    return std::nullopt;
  }
  const bool sphere_is_lower = sphere_side == Side::lower;
  return SphereOnFlat{sphere_is_lower ? Vector3(-flat.normal) : flat.normal, sphere.centre_offset(), sphere_is_lower,
                      gap, sphere.radius};
}

}  // namespace stiction
