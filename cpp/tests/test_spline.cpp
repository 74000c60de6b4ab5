#include "stiction/spline.hpp"

#include <doctest/doctest.h>
#include <gsl/gsl_spline.h>

#include <cmath>
#include <random>
#include <vector>

namespace {

std::vector<double> rough_heights(std::size_t size) {
  std::mt19937_64 random(7);
  std::vector<double> heights(size);
  for (double& height : heights) {
    height = static_cast<double>(random() >> 11) * 0x1p-53;
  }
  return heights;
}

struct Derivatives {
  std::vector<double> slope;
  std::vector<double> curvature;
};

Derivatives derivatives(const std::vector<double>& heights, double spacing) {
  Derivatives result{std::vector<double>(heights.size()), std::vector<double>(heights.size())};
  stiction::natural_spline(heights, spacing, result.slope, result.curvature);
  return result;
}

}  // namespace

TEST_CASE("the natural spline is GSL's own, evaluated at its knots") {
  constexpr double spacing = 0.25;
  // GSL evaluates slopes from one side by a longer expression; both round at the size of the slopes, about 1/spacing.
  constexpr double tolerance = 1e-12;
  for (const std::size_t size : {4U, 5U, 64U, 1001U}) {
    const std::vector<double> heights = rough_heights(size);
    std::vector<double> knots(size);
    for (std::size_t i = 0; i < size; ++i) {
      knots[i] = static_cast<double>(i);
    }
    gsl_spline* spline = gsl_spline_alloc(gsl_interp_cspline, size);
    REQUIRE(gsl_spline_init(spline, knots.data(), heights.data(), size) == 0);
    const Derivatives ours = derivatives(heights, spacing);
    for (std::size_t i = 0; i < size; ++i) {
      double slope = 0.0;
      double curvature = 0.0;
      REQUIRE(gsl_spline_eval_deriv_e(spline, knots[i], nullptr, &slope) == 0);
      REQUIRE(gsl_spline_eval_deriv2_e(spline, knots[i], nullptr, &curvature) == 0);
      CHECK(std::abs(ours.slope[i] - slope / spacing) < tolerance);
      CHECK(std::abs(ours.curvature[i] - curvature / (spacing * spacing)) < tolerance / spacing);
    }
    gsl_spline_free(spline);
  }
}

TEST_CASE("a straight line has its slope and no curvature") {
  std::vector<double> heights;
  for (int i = 0; i < 20; ++i) {
    heights.push_back(3.0 - 0.5 * i);
  }
  const Derivatives line = derivatives(heights, 0.125);
  for (std::size_t i = 0; i < heights.size(); ++i) {
    CHECK(line.slope[i] == -4.0);
    CHECK(line.curvature[i] == 0.0);
  }
}

TEST_CASE("a window reaches far enough to give the derivatives of the whole spline") {
  const std::vector<double> heights = rough_heights(1000);
  const Derivatives whole = derivatives(heights, 1.0);
  constexpr auto reach = static_cast<std::size_t>(stiction::spline_reach);
  for (const std::size_t first : {0U, 1U, 300U, 900U}) {
    const std::size_t last = std::min<std::size_t>(first + 30, heights.size() - 1);
    const std::size_t begin = first > reach ? first - reach : 0;
    const std::size_t end = std::min(last + 1 + reach, heights.size());
    const Derivatives window = derivatives(
        {heights.begin() + static_cast<std::ptrdiff_t>(begin), heights.begin() + static_cast<std::ptrdiff_t>(end)},
        1.0);
    for (std::size_t i = first; i <= last; ++i) {
      CHECK(window.slope[i - begin] == whole.slope[i]);
      CHECK(window.curvature[i - begin] == whole.curvature[i]);
    }
  }
}

TEST_CASE("the spline refuses what it cannot pass through") {
  CHECK_THROWS_AS(derivatives({1.0, 2.0, 3.0}, 1.0), std::invalid_argument);
  CHECK_THROWS_AS(derivatives({1.0, 2.0, 3.0, 4.0}, 0.0), std::invalid_argument);
  CHECK_THROWS_AS(derivatives({1.0, 2.0, 3.0, 4.0}, std::nan("")), std::invalid_argument);
  std::vector<double> heights(5);
  std::vector<double> shorter(4);
  CHECK_THROWS_AS(stiction::natural_spline(heights, 1.0, shorter, heights), std::invalid_argument);
}
