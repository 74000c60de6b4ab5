#include "stiction/asperity.hpp"

#include "stiction/spline.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace stiction {

Side side(std::string_view name) {
  if (name == "lower") {
    return Side::lower;
  }
  if (name == "upper") {
    return Side::upper;
  }
  throw std::invalid_argument("side must be lower or upper, got " + std::string(name));
}

Asperity asperity(double slope, double curvature, Side side) {
  const double sign = side == Side::lower ? 1.0 : -1.0;
  const double q = std::sqrt(1.0 + slope * slope);
  return {Vector3(sign * (-slope / q), 0.0, sign * (1.0 / q)),
          curvature == 0.0 ? std::numeric_limits<double>::infinity() : -sign * q * q * q / curvature};
}

Asperities asperities(Values heights, double spacing, Side side) {
  const std::size_t size = heights.size();
  Asperities result{std::vector<double>(size), std::vector<double>(size), std::vector<Vector3>(size),
                    std::vector<double>(size), std::vector<Vector3>(size)};
  natural_spline(heights, spacing, result.slope, result.curvature);
  for (std::size_t i = 0; i < size; ++i) {
    const Asperity point = asperity(result.slope[i], result.curvature[i], side);
    result.normal[i] = point.normal;
    result.radius[i] = point.radius;
    result.centre[i] = Vector3(static_cast<double>(i) * spacing, 0.0, heights[i]) + point.centre_offset();
  }
  return result;
}

}  // namespace stiction
