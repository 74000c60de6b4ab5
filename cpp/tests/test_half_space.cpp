#include "stiction/half_space.hpp"

#include <Eigen/Cholesky>

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <vector>

using stiction::Crew;
using stiction::Grid;
using stiction::HalfSpaceGrids;
using stiction::HalfSpaceSolution;
using stiction::HalfSpaceSolver;

namespace {

constexpr double modulus = 10.0;
constexpr double tight = 1e-10;
constexpr double of_compliance = 1e-6;
constexpr double of_answer = 5e-3;  // pressures, whose energy is right to the square of it
const std::vector<double> unbounded{std::numeric_limits<double>::infinity()};

// Waves of several lengths, as a map or a line.
std::vector<double> waves(const Grid& grid) {
  std::vector<double> heights(grid.size());
  for (std::size_t row = 0; row < grid.rows; ++row) {
    for (std::size_t column = 0; column < grid.columns; ++column) {
      const auto x = static_cast<double>(column) / static_cast<double>(grid.columns);
      const auto y = static_cast<double>(row) / static_cast<double>(grid.rows);
      heights[row * grid.columns + column] = 0.01 * (std::cos(6.28 * (x + 2 * y) + 1) + 0.5 * std::cos(6.28 * 3 * x) +
                                                     0.4 * std::cos(6.28 * (2 * x - 3 * y)));
    }
  }
  return heights;
}

// Every point under pressure below its bound is at the approach, none overlaps but at its bound, and none is open
// there; and the pressure has the mean.
void check_pressed(const HalfSpaceGrids& grids, const std::vector<double>& gap, const std::vector<double>& bound,
                   double mean, double unit, const HalfSpaceSolution& found) {
  const std::size_t size = gap.size();
  stiction::Workspace workspace;
  std::vector<double> moved(size);
  grids.kernels().points->displacement(found.pressure, moved, workspace);
  double worst = 0.0;
  for (std::size_t i = 0; i < size; ++i) {
    const double open = moved[i] + gap[i] - found.approach;
    const double most = bound.size() == 1 ? bound[0] : bound[i];
    CHECK(found.pressure[i] >= 0.0);
    CHECK(found.pressure[i] <= most);
    worst = std::max(worst, found.pressure[i] > 0.0 ? open : 0.0);
    worst = std::max(worst, found.pressure[i] < most ? -open : 0.0);
  }
  CHECK(worst <= 2 * tight * unit);
  CHECK(std::accumulate(found.pressure.begin(), found.pressure.end(), 0.0) / static_cast<double>(size) ==
        doctest::Approx(mean).epsilon(1e-9));
}

}  // namespace

TEST_CASE("pressures meet what is asked of them on lines and areas, whatever bounds them") {
  for (const bool periodic : {true, false}) {
    for (const Grid& grid : {Grid{1, 63, 1.0, 0.02, true, periodic}, Grid{1, 200, 1.0, 0.01, true, periodic},
                             Grid{33, 50, 0.05, 0.04, false, periodic}}) {
      const auto grids = std::make_shared<const HalfSpaceGrids>(grid, modulus);
      const std::vector<double> gap = waves(grid);
      std::vector<double> uneven(grid.size());
      for (std::size_t i = 0; i < uneven.size(); ++i) {
        uneven[i] = i % 7 == 0 ? 0.0 : 0.1 + 0.01 * static_cast<double>(i % 5);
      }
      for (const std::vector<double>& bound : {unbounded, std::vector<double>{0.2}, uneven}) {
        const HalfSpaceSolver solver(gap, grids, bound, tight);
        std::vector<double> near;
        for (const double mean : {0.01, 0.05, 0.06}) {
          const HalfSpaceSolution found = solver.at(mean, near);
          REQUIRE(found.error <= tight);
          check_pressed(*grids, gap, bound, mean, solver.scale(mean), found);
          near = found.pressure;
        }
      }
    }
  }
}

TEST_CASE("threads change no bits of a solution") {
  for (const bool periodic : {false, true}) {
    const Grid grid{500, 480, 0.005, 0.005, false, periodic};
    const auto grids = std::make_shared<const HalfSpaceGrids>(grid, modulus);
    const std::vector<double> gap = waves(grid);
    const std::vector<double> bound{periodic ? 1.0 : unbounded[0]};
    const HalfSpaceSolver solver(gap, grids, bound, 1e-6);
    const HalfSpaceSolution alone = solver.at(0.4);
    const auto loaded = std::count_if(alone.pressure.begin(), alone.pressure.end(), [](double p) { return p > 0.0; });
    CHECK(loaded > 1 << 16);  // points of several parts, which threads share
    for (const std::size_t threads : {2U, 3U}) {
      const HalfSpaceSolution together = solver.at(0.4, {}, Crew(threads));
      CHECK(together.pressure == alone.pressure);
      CHECK(together.approach == alone.approach);
    }
  }
}

TEST_CASE("an approach is met by the load that it takes") {
  const Grid grid{24, 20, 0.05, 0.05, false, true};
  const auto grids = std::make_shared<const HalfSpaceGrids>(grid, modulus);
  const std::vector<double> gap = waves(grid);
  const HalfSpaceSolver solver(gap, grids, unbounded, 1e-8);
  const double lowest = *std::min_element(gap.begin(), gap.end());
  std::vector<double> above(gap);
  for (double& one : above) {
    one -= lowest;
  }
  const HalfSpaceSolver raised(above, grids, unbounded, 1e-8);
  const HalfSpaceSolution found = raised.at_approach(0.005);
  CHECK(found.error <= 1e-8);
  CHECK(found.approach == doctest::Approx(0.005).epsilon(1e-6));
}

TEST_CASE("the answer to a load is that of the matrix of the points, few or many") {
  for (const Grid& grid :
       {Grid{1, 60, 1.0, 0.1, true, true}, Grid{40, 40, 0.1, 0.1, false, true}, Grid{40, 40, 0.1, 0.1, false, false}}) {
    const HalfSpaceGrids grids(grid, modulus);
    for (const std::size_t every : {2U, 5U}) {
      const auto free = std::make_unique<bool[]>(grid.size());
      std::vector<std::size_t> points;
      for (std::size_t i = 0; i < grid.size(); ++i) {
        free[i] = every == 2 ? i % 5 != 0 : i % 5 == 0;
        if (free[i]) {
          points.push_back(i);
        }
      }
      const auto influence = grids.influence();
      const auto size = static_cast<Eigen::Index>(points.size());
      Eigen::MatrixXd matrix(size, size);
      for (Eigen::Index i = 0; i < size; ++i) {
        for (Eigen::Index j = 0; j < size; ++j) {
          const std::size_t one = points[static_cast<std::size_t>(i)];
          const std::size_t other = points[static_cast<std::size_t>(j)];
          const auto away = [](std::size_t a, std::size_t b) { return a > b ? a - b : b - a; };
          matrix(i, j) = influence[away(one / grid.columns, other / grid.columns) * grid.columns +
                                   away(one % grid.columns, other % grid.columns)];
        }
      }
      const Eigen::VectorXd even = matrix.ldlt().solve(Eigen::VectorXd::Ones(size));
      REQUIRE(even.minCoeff() > 0.0);
      const stiction::LinearAnswer found = stiction::linear_answer(grids, {free.get(), grid.size()});
      CHECK(found.compliance == doctest::Approx(1.0 / even.sum()).epsilon(of_compliance));
      double difference = 0.0;
      for (Eigen::Index i = 0; i < size; ++i) {
        const double pressure = found.pressure[points[static_cast<std::size_t>(i)]];
        difference = std::max(difference, std::abs(pressure * even.sum() - even[i]));
      }
      CHECK(difference < of_answer * even.maxCoeff());
      CHECK(std::accumulate(found.pressure.begin(), found.pressure.end(), 0.0) == doctest::Approx(1.0));
    }
  }
  const HalfSpaceGrids grids(Grid{8, 8, 0.1, 0.1, false, true}, modulus);
  std::array<bool, 64> all{};
  CHECK_THROWS_AS(stiction::linear_answer(grids, all), std::invalid_argument);
  all.fill(true);
  CHECK(stiction::linear_answer(grids, all).compliance == 0.0);
}

TEST_CASE("what is no problem is refused, and progress can end a solution") {
  const Grid grid{1, 40, 1.0, 0.1, true, true};
  const auto grids = std::make_shared<const HalfSpaceGrids>(grid, modulus);
  const std::vector<double> gap = waves(grid);
  const std::vector<double> short_gap(39);
  CHECK_THROWS_AS(HalfSpaceSolver(short_gap, grids, unbounded, tight), std::invalid_argument);
  CHECK_THROWS_AS(HalfSpaceSolver(gap, grids, short_gap, tight), std::invalid_argument);
  CHECK_THROWS_AS(HalfSpaceSolver(gap, grids, unbounded, 0.0), std::invalid_argument);
  const HalfSpaceSolver solver(gap, grids, unbounded, tight);
  CHECK_THROWS_AS(solver.at(-1.0), std::invalid_argument);
  CHECK_THROWS_AS(solver.at(0.1, short_gap), std::invalid_argument);
  const auto stop = [](std::int64_t, double) { throw std::length_error("stop"); };
  CHECK_THROWS_AS(solver.at(0.1, {}, Crew(), stop), std::length_error);
}
