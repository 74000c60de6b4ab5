#include "stiction/spline.hpp"

#include <doctest/doctest.h>
#include <gsl/gsl_spline.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>
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

TEST_CASE("natural_spline: matches GSL's spline at its knots") {
  constexpr double spacing = 0.25;
  // GSL computes a slope from one cubic, natural_spline from two cubics. Their round-off is proportional to 1/spacing.
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

TEST_CASE("natural_spline: a straight line has constant slope and zero curvature") {
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

TEST_CASE("natural_spline_from: matches the complete spline, including its ends") {
  for (const std::size_t size : {4U, 5U, 30U, 1000U}) {
    const std::vector<double> heights = rough_heights(size);
    const Derivatives whole = derivatives(heights, 0.5);
    for (const std::size_t first : {0U, 1U, 3U, 300U, 960U}) {
      for (const std::size_t count : {1U, 31U, 255U, 256U, 257U, 700U, 1000U}) {
        if (first + count > size && !(first < size && count > size)) {
          continue;
        }
        const std::size_t points = std::min(count, size - first);
        Derivatives range{std::vector<double>(points), std::vector<double>(points)};
        stiction::natural_spline_from(heights, 0.5, static_cast<stiction::Index>(first), range.slope, range.curvature);
        double max_error = 0.0;
        for (std::size_t i = 0; i < points; ++i) {
          max_error = std::max({max_error, std::abs(range.slope[i] - whole.slope[first + i]),
                                std::abs(range.curvature[i] - whole.curvature[first + i])});
        }
        CAPTURE(size);
        CAPTURE(first);
        CAPTURE(points);
        CHECK(max_error < 1e-13);  // the largest curvature is about 30
      }
    }
  }
}

TEST_CASE("natural_spline_from: the derivatives at a point do not depend on the requested range") {
  const std::vector<double> heights = rough_heights(1000);
  Derivatives all{std::vector<double>(1000), std::vector<double>(1000)};
  stiction::natural_spline_from(heights, 0.5, 0, all.slope, all.curvature);
  for (std::size_t first = 0; first < 1000; ++first) {
    const std::size_t points = std::min<std::size_t>(1000 - first, 1 + first % 90);
    Derivatives range{std::vector<double>(points), std::vector<double>(points)};
    stiction::natural_spline_from(heights, 0.5, static_cast<stiction::Index>(first), range.slope, range.curvature);
    for (std::size_t i = 0; i < points; ++i) {
      CHECK(range.slope[i] == all.slope[first + i]);
      CHECK(range.curvature[i] == all.curvature[first + i]);
    }
  }
}

TEST_CASE("natural_spline: invalid arguments throw") {
  CHECK_THROWS_AS(derivatives({1.0, 2.0, 3.0}, 1.0), std::invalid_argument);
  CHECK_THROWS_AS(derivatives({1.0, 2.0, 3.0, 4.0}, 0.0), std::invalid_argument);
  CHECK_THROWS_AS(derivatives({1.0, 2.0, 3.0, 4.0}, std::nan("")), std::invalid_argument);
  std::vector<double> heights(5);
  std::vector<double> shorter(4);
  CHECK_THROWS_AS(stiction::natural_spline(heights, 1.0, shorter, heights), std::invalid_argument);
  CHECK_THROWS_AS(stiction::natural_spline_from(heights, 1.0, 2, shorter, shorter), std::invalid_argument);
  CHECK_THROWS_AS(stiction::natural_spline_from(heights, 1.0, -1, shorter, shorter), std::invalid_argument);
}
