#include "stiction/asperity.hpp"

#include "stiction/spline.hpp"

#include <cmath>
#include <limits>

namespace stiction {

Asperity asperity(double slope, double curvature, Side side) {
  const double sign = side == Side::lower ? 1.0 : -1.0;
  const double q = std::sqrt(1.0 + slope * slope);
  return {sign * Vector2(-slope / q, 1.0 / q),
          curvature == 0.0 ? std::numeric_limits<double>::infinity() : -sign * q * q * q / curvature};
}

Asperities asperities(Values heights, double spacing, Side side) {
  const std::size_t size = heights.size();
  const auto rows = static_cast<Index>(size);
  Asperities result{std::vector<double>(size), std::vector<double>(size), Matrix(rows, 2), std::vector<double>(size),
                    Matrix(rows, 2)};
  natural_spline(heights, spacing, result.slope, result.curvature);
  for (Index j = 0; j < rows; ++j) {
    const auto i = static_cast<std::size_t>(j);
    const Asperity at = asperity(result.slope[i], result.curvature[i], side);
    result.normal.row(j) = at.normal;
    result.radius[i] = at.radius;
    result.centre.row(j) = Vector2(static_cast<double>(j) * spacing, heights[i]) + at.centre_offset();
  }
  return result;
}

}  // namespace stiction
