#include "stiction/spline.hpp"

#include "gsl.hpp"

#include <stdexcept>
#include <string>
#include <vector>

namespace stiction {

void natural_spline(Values heights, double spacing, std::span<double> slope, std::span<double> curvature) {
  const std::size_t size = heights.size();
  if (size < 4) {
    throw std::invalid_argument("natural_spline: heights has " + std::to_string(size) +
                                " values, at least 4 are needed");
  }
  if (!(spacing > 0.0)) {
    throw std::invalid_argument("natural_spline: spacing is " + std::to_string(spacing) + " µm, must be above 0");
  }
  if (slope.size() != size || curvature.size() != size) {
    throw std::invalid_argument("natural_spline: slope and curvature must be as long as heights");
  }
  // f''_(i-1) + 4 f''_i + f''_(i+1) = 6 (y_(i-1) - 2 y_i + y_(i+1)) / Δx², and f'' = 0 at both ends.
  const double scale = 6.0 / (spacing * spacing);
  std::vector<double> right_side(size - 2);
  for (std::size_t i = 1; i + 1 < size; ++i) {
    right_side[i - 1] = scale * ((heights[i + 1] - heights[i]) - (heights[i] - heights[i - 1]));
  }
  curvature.front() = 0.0;
  curvature.back() = 0.0;
  gsl::solve_tridiagonal(4.0, 1.0, right_side, curvature.subspan(1, size - 2));

  // The mean of the two cubics' slopes at a point, which are equal: symmetric in x, so a mirrored profile has mirrored
  // slopes to the last bit.
  for (std::size_t i = 1; i + 1 < size; ++i) {
    slope[i] =
        (heights[i + 1] - heights[i - 1]) / (2.0 * spacing) - spacing * (curvature[i + 1] - curvature[i - 1]) / 12.0;
  }
  slope.front() = (heights[1] - heights[0]) / spacing - spacing * curvature[1] / 6.0;
  slope.back() = (heights[size - 1] - heights[size - 2]) / spacing + spacing * curvature[size - 2] / 6.0;
}

}  // namespace stiction
