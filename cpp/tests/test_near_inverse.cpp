#include "stiction/near_inverse.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <random>
#include <stdexcept>
#include <vector>

using namespace stiction;

namespace {

constexpr double modulus = 10.0;
const Grid area{96, 128, 0.1, 0.1, false, true};

struct Inverse {
  ElasticKernel kernel{area, modulus};
  ElasticKernel blocks{NearInverse::blocks_of(area), modulus};
  NearInverse inverse{area, kernel.stencil(), blocks};
  Workspace workspace;
};

// Points of discs on a square lattice, a part of the area.
std::vector<std::int32_t> dots(double part) {
  std::vector<std::int32_t> points;
  const double radius = 12.0 * std::sqrt(part / std::numbers::pi);
  for (std::size_t i = 0; i < area.size(); ++i) {
    const double y = static_cast<double>(i / area.columns % 12) - 5.5;
    const double x = static_cast<double>(i % area.columns % 12) - 5.5;
    if (std::hypot(x, y) <= radius) {
      points.push_back(static_cast<std::int32_t>(i));
    }
  }
  return points;
}

double product(const std::vector<std::int32_t>& points, std::span<const float> left, std::span<const float> right) {
  double sum = 0.0;
  for (const std::int32_t point : points) {
    const auto i = static_cast<std::size_t>(point);
    sum += static_cast<double>(left[i]) * static_cast<double>(right[i]);
  }
  return sum;
}

std::vector<float> on(const std::vector<std::int32_t>& points, std::span<const float> values) {
  std::vector<float> result(area.size(), 0.0F);
  for (const std::int32_t point : points) {
    result[static_cast<std::size_t>(point)] = values[static_cast<std::size_t>(point)];
  }
  return result;
}

std::vector<float> random(std::uint32_t seed) {
  std::mt19937 engine(seed);
  std::normal_distribution<float> normal;
  std::vector<float> values(area.size());
  for (float& value : values) {
    value = normal(engine);
  }
  return values;
}

}  // namespace

TEST_CASE("the near inverse takes back what long waves of pressure on contacts do") {
  for (const double part : {0.05, 0.3, 0.7}) {
    const std::vector<std::int32_t> points = dots(part);
    for (const double waves : {1.0, 2.0, 4.0}) {
      std::vector<float> wave(area.size());
      for (std::size_t i = 0; i < wave.size(); ++i) {
        const auto x = static_cast<double>(i % area.columns) / static_cast<double>(area.columns);
        wave[i] = static_cast<float>(std::cos(2 * std::numbers::pi * waves * x));
      }
      Inverse one;
      const std::vector<float> pressure = on(points, wave);
      std::vector<float> moved(area.size());
      one.kernel.displacement(pressure, moved, one.workspace);
      const auto back = one.inverse(points, on(points, moved), one.workspace);
      // By the stencil alone the longest is taken back 3 to 20 times.
      const double ratio = product(points, back, pressure) / product(points, pressure, pressure);
      CHECK(ratio > 0.5);
      CHECK(ratio < 2.0);
    }
  }
}

TEST_CASE("the near inverse is symmetric and positive, to the answer of the blocks") {
  const std::vector<std::int32_t> points = dots(0.2);
  Inverse one;
  const std::vector<float> left = on(points, random(1));
  const std::vector<float> right = on(points, random(2));
  const auto of_left = one.inverse(points, left, one.workspace);
  const double there = product(points, of_left, right);
  const double square = product(points, of_left, left);
  const auto of_right = one.inverse(points, right, one.workspace);
  CHECK(square > 0.0);
  CHECK(product(points, of_right, right) > 0.0);
  CHECK(std::abs(there - product(points, of_right, left)) < 1e-3 * square);
}

TEST_CASE("its stencil adds up what is around each free point, over the edges too") {
  // Weights of sum 0 leave the blocks nothing to answer.
  const Grid small{3, 4, 0.1, 0.1, false, true};
  const ElasticKernel blocks(NearInverse::blocks_of(small), modulus);
  const std::vector<double> stencil{0.0, 0.0, 0.0, -3.0, 0.0, 1.0, 0.0, 2.0, 0.0};
  NearInverse inverse(small, stencil, blocks);
  std::vector<std::int32_t> points(12);
  std::vector<float> values(12);
  std::iota(points.begin(), points.end(), 0);
  std::iota(values.begin(), values.end(), 0.0F);
  Workspace workspace;
  const auto sums = inverse(points, values, workspace);
  for (std::size_t i = 0; i < 12; ++i) {
    const auto left = static_cast<double>(i % 4 == 0 ? i + 3 : i - 1);
    const auto right = static_cast<double>(i % 4 == 3 ? i - 3 : i + 1);
    const auto below = static_cast<double>((i + 4) % 12);
    CHECK(static_cast<double>(sums[i]) == right + 2.0 * below - 3.0 * left);
  }
}

TEST_CASE("threads change no bits of the near inverse") {
  std::vector<std::int32_t> points(area.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = static_cast<std::int32_t>(i);
  }
  Inverse one;
  const std::vector<float> moved = random(3);
  const std::vector<float> alone = on(points, one.inverse(points, moved, one.workspace));
  Inverse other;
  const Crew crew(3);
  CHECK(on(points, other.inverse(points, moved, other.workspace, crew)) == alone);
}

TEST_CASE("the near inverse refuses what is not of its area") {
  Inverse one;
  const std::vector<std::int32_t> points = dots(0.2);
  CHECK_THROWS_AS(one.inverse(points, std::vector<float>(5), one.workspace), std::invalid_argument);
  CHECK_THROWS_AS(NearInverse(area, std::vector<double>(8), one.blocks), std::invalid_argument);
  CHECK_THROWS_AS(NearInverse(area, one.kernel.stencil(), one.kernel), std::invalid_argument);
}
