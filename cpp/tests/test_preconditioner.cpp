#include "stiction/preconditioner.hpp"

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

struct Fixture {
  ElasticKernel kernel{area, modulus};
  ElasticKernel blocks{Preconditioner::block_grid(area), modulus};
  Preconditioner preconditioner{area, kernel.stencil(), blocks};
  Workspace workspace;
};

std::vector<std::int32_t> lattice_of_discs(double fraction) {
  std::vector<std::int32_t> points;
  const double radius = 12.0 * std::sqrt(fraction / std::numbers::pi);
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

std::vector<float> restricted_to(const std::vector<std::int32_t>& points, std::span<const float> values) {
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

TEST_CASE("Preconditioner: recovers pressures of long wavelength from their displacements") {
  for (const double fraction : {0.05, 0.3, 0.7}) {
    const std::vector<std::int32_t> points = lattice_of_discs(fraction);
    for (const double periods : {1.0, 2.0, 4.0}) {
      std::vector<float> pressure_wave(area.size());
      for (std::size_t i = 0; i < pressure_wave.size(); ++i) {
        const auto x = static_cast<double>(i % area.columns) / static_cast<double>(area.columns);
        pressure_wave[i] = static_cast<float>(std::cos(2 * std::numbers::pi * periods * x));
      }
      Fixture fixture;
      const std::vector<float> pressure = restricted_to(points, pressure_wave);
      std::vector<float> displacement(area.size());
      fixture.kernel.displacement(pressure, displacement, fixture.workspace);
      const auto recovered = fixture.preconditioner(points, restricted_to(points, displacement), fixture.workspace);
      // With the stencil alone, the recovered pressures would be 3 to 20 times too large at the longest wavelength.
      const double ratio = product(points, recovered, pressure) / product(points, pressure, pressure);
      CHECK(ratio > 0.5);
      CHECK(ratio < 2.0);
    }
  }
}

TEST_CASE("Preconditioner: is symmetric and positive, to the tolerance of the block solution") {
  const std::vector<std::int32_t> points = lattice_of_discs(0.2);
  Fixture fixture;
  const std::vector<float> left = restricted_to(points, random(1));
  const std::vector<float> right = restricted_to(points, random(2));
  const auto left_pressure = fixture.preconditioner(points, left, fixture.workspace);
  const double product_left_right = product(points, left_pressure, right);
  const double square = product(points, left_pressure, left);
  const auto right_pressure = fixture.preconditioner(points, right, fixture.workspace);
  CHECK(square > 0.0);
  CHECK(product(points, right_pressure, right) > 0.0);
  CHECK(std::abs(product_left_right - product(points, right_pressure, left)) < 1e-3 * square);
}

TEST_CASE("Preconditioner: applies the stencil periodically at each free point") {
  // The weights of this stencil add up to 0, which makes the correction by blocks of points vanish.
  const Grid small{3, 4, 0.1, 0.1, false, true};
  const ElasticKernel blocks(Preconditioner::block_grid(small), modulus);
  const std::vector<double> stencil{0.0, 0.0, 0.0, -3.0, 0.0, 1.0, 0.0, 2.0, 0.0};
  Preconditioner preconditioner(small, stencil, blocks);
  std::vector<std::int32_t> points(12);
  std::vector<float> values(12);
  std::iota(points.begin(), points.end(), 0);
  std::iota(values.begin(), values.end(), 0.0F);
  Workspace workspace;
  const auto sums = preconditioner(points, values, workspace);
  for (std::size_t i = 0; i < 12; ++i) {
    const auto left = static_cast<double>(i % 4 == 0 ? i + 3 : i - 1);
    const auto right = static_cast<double>(i % 4 == 3 ? i - 3 : i + 1);
    const auto below = static_cast<double>((i + 4) % 12);
    CHECK(static_cast<double>(sums[i]) == right + 2.0 * below - 3.0 * left);
  }
}

TEST_CASE("Preconditioner: results are bit-identical for any number of threads") {
  std::vector<std::int32_t> points(area.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = static_cast<std::int32_t>(i);
  }
  Fixture fixture;
  const std::vector<float> displacement = random(3);
  const std::vector<float> alone =
      restricted_to(points, fixture.preconditioner(points, displacement, fixture.workspace));
  Fixture other;
  const ThreadPool pool(3);
  CHECK(restricted_to(points, other.preconditioner(points, displacement, other.workspace, pool)) == alone);
}

TEST_CASE("Preconditioner: arguments that do not match the area throw") {
  Fixture fixture;
  const std::vector<std::int32_t> points = lattice_of_discs(0.2);
  CHECK_THROWS_AS(fixture.preconditioner(points, std::vector<float>(5), fixture.workspace), std::invalid_argument);
  CHECK_THROWS_AS(Preconditioner(area, std::vector<double>(8), fixture.blocks), std::invalid_argument);
  CHECK_THROWS_AS(Preconditioner(area, fixture.kernel.stencil(), fixture.kernel), std::invalid_argument);
}
