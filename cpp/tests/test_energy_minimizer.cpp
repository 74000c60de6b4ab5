#include "stiction/energy_minimizer.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <vector>

using namespace stiction;

namespace {

constexpr double modulus = 2e-3;
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double round_off = 1e-10;
constexpr double residual_limit = 1e-5;
constexpr int max_steps = 2000;
const MinimizationLimits limits{residual_limit, 10 * residual_limit, 1e-7};

Grid area(bool periodic) { return {24, 20, 0.1, 0.12, false, periodic}; }
Grid line(bool periodic) { return {1, 64, 1.0, 0.1, true, periodic}; }

std::vector<double> wavy_gap(const Grid& grid) {
  std::vector<double> gap(grid.size());
  for (std::size_t i = 0; i < gap.size(); ++i) {
    const auto y = static_cast<double>(i / grid.columns) / static_cast<double>(grid.rows);
    const auto x = static_cast<double>(i % grid.columns) / static_cast<double>(grid.columns);
    gap[i] = 0.05 * (2.0 - std::cos(6.3 * (x + y)) * std::cos(12.6 * x - 6.3 * y) + 0.3 * std::sin(25.0 * x + 1.0));
  }
  const double lowest = *std::min_element(gap.begin(), gap.end());
  for (double& value : gap) {
    value -= lowest;
  }
  return gap;
}

struct Minimization {
  Grid grid;
  AdhesiveInterface interface;
  std::vector<double> gap = wavy_gap(grid);
  EnergyMinimizer minimizer{gap, grid, modulus, interface};
  MinimizationState state{};

  MinimizationState start(double load) {
    const std::vector<double> pressure(grid.size(), interface.max_attraction / 2);
    const std::vector<double> attraction(grid.size(), interface.max_attraction);
    return minimizer.start(pressure, attraction, load);
  }

  MinimizationOutcome run(double load, const ThreadPool& pool = ThreadPool()) {
    state = start(load);
    MinimizationOutcome outcome = MinimizationOutcome::unfinished;
    for (int count = 0; count < max_steps && outcome == MinimizationOutcome::unfinished; ++count) {
      outcome = minimizer.step(state, load, limits, pool);
    }
    return outcome;
  }
};

AdhesiveInterface soft_interface(double hardness = infinity) { return {1.5e-4, 0.02, hardness}; }

}  // namespace

TEST_CASE("EnergyMinimizer: the minimum is an equilibrium of pressure, attraction and displacement") {
  const double load = -2e-5;
  for (const bool periodic : {false, true}) {
    for (const Grid& grid : {area(periodic), line(periodic)}) {
      for (const double hardness : {infinity, 3e-4}) {
        Minimization minimization{grid, soft_interface(hardness)};
        REQUIRE(minimization.run(load) == MinimizationOutcome::balanced);
        const AdhesiveStresses stresses = minimization.minimizer.stresses(minimization.state);
        std::vector<double> displacement(grid.size());
        double net_load = 0.0;
        double mean_stress = 0.0;
        for (std::size_t i = 0; i < grid.size(); ++i) {
          displacement[i] = stresses.pressure[i] - stresses.attraction[i];
          net_load += displacement[i] / static_cast<double>(grid.size());
          mean_stress += (stresses.pressure[i] + stresses.attraction[i]) / static_cast<double>(grid.size());
        }
        CHECK(std::abs(net_load - load) < 2 * residual_limit * mean_stress);
        Workspace workspace;
        ElasticKernel(grid, modulus).displacement(displacement, displacement, workspace);
        double closed_gap = 0.0;
        double closed_count = 0.0;
        for (std::size_t i = 0; i < grid.size(); ++i) {
          const bool is_elastic = stresses.pressure[i] > 0.0 && stresses.pressure[i] < hardness;
          closed_gap += is_elastic ? minimization.gap[i] + displacement[i] : 0.0;
          closed_count += is_elastic ? 1.0 : 0.0;
        }
        REQUIRE(closed_count > 0.0);
        double difference = 0.0;
        for (std::size_t i = 0; i < grid.size(); ++i) {
          const double gap = minimization.gap[i] + displacement[i] - closed_gap / closed_count;
          difference += std::abs(gap - minimization.state.gap[i]) / static_cast<double>(grid.size());
          CHECK((stresses.pressure[i] == 0.0 || minimization.state.gap[i] <= 0.0));
          CHECK((stresses.pressure[i] == hardness || minimization.state.gap[i] >= 0.0));
          CHECK(stresses.pressure[i] >= 0.0);
          CHECK(stresses.pressure[i] <= hardness);
        }
        CHECK(difference < 1e-3 * minimization.interface.range);
      }
    }
  }
}

TEST_CASE("EnergyMinimizer: the bodies separate under a tension above the largest attraction") {
  for (const bool periodic : {false, true}) {
    Minimization minimization{area(periodic), soft_interface()};
    CHECK(minimization.run(-1.01 * minimization.interface.max_attraction) == MinimizationOutcome::separated);
  }
}

TEST_CASE("EnergyMinimizer: the minimum has the same bits for any number of threads") {
  const Grid grid{128, 96, 0.1, 0.1, false, false};
  Minimization single{grid, soft_interface()};
  Minimization parallel{grid, soft_interface()};
  CHECK(single.run(-1e-5) == parallel.run(-1e-5, ThreadPool(3)));
  CHECK(single.state.number == parallel.state.number);
  CHECK(single.state.gap == parallel.state.gap);
  CHECK(single.state.net_pressure == parallel.state.net_pressure);
}

TEST_CASE("EnergyMinimizer: a copied state continues with the same bits") {
  Minimization minimization{area(false), soft_interface()};
  MinimizationState state = minimization.start(-1e-5);
  for (int count = 0; count < 7; ++count) {
    minimization.minimizer.step(state, -1e-5, limits);
  }
  MinimizationState copy = state;
  minimization.minimizer.step(state, -1e-5, limits);
  Minimization other{area(false), soft_interface()};
  other.minimizer.step(copy, -1e-5, limits);
  CHECK(state.gap == copy.gap);
  CHECK(state.net_pressure == copy.net_pressure);
  CHECK(state.direction == copy.direction);
}

TEST_CASE("EnergyMinimizer: rejects arrays of other grids, and a range or hardness of 0") {
  const Grid grid = area(false);
  const std::vector<double> gap = wavy_gap(grid);
  CHECK_THROWS_AS(EnergyMinimizer(gap, line(false), modulus, soft_interface()), std::invalid_argument);
  CHECK_THROWS_AS(EnergyMinimizer(gap, grid, modulus, {1e-4, 0.0, infinity}), std::invalid_argument);
  CHECK_THROWS_AS(EnergyMinimizer(gap, grid, modulus, {1e-4, 0.01, 0.0}), std::invalid_argument);
  EnergyMinimizer minimizer(gap, grid, modulus, soft_interface());
  CHECK_THROWS_AS(minimizer.start(std::vector<double>(3), gap, 0.0), std::invalid_argument);
  MinimizationState state;
  CHECK_THROWS_AS(minimizer.step(state, 0.0, limits), std::invalid_argument);
}

TEST_CASE("StiffnessKernel: displacement within a grid equals that of ElasticKernel up to a constant") {
  for (const bool periodic : {false, true}) {
    for (const Grid& grid : {area(periodic), line(periodic)}) {
      const StiffnessKernel stiffness(grid, modulus);
      const std::vector<double> pressure = wavy_gap(grid);
      std::vector<double> extended(stiffness.size(), 0.0);
      for (std::size_t i = 0; i < grid.size(); ++i) {
        extended[i / grid.columns * stiffness.columns() + i % grid.columns] = pressure[i];
      }
      const std::vector<double> extended_pressure = extended;
      Workspace workspace;
      stiffness.displacement(extended, extended, workspace);
      std::vector<double> displacement(grid.size());
      ElasticKernel(grid, modulus).displacement(pressure, displacement, workspace);
      const double scale = *std::max_element(displacement.begin(), displacement.end());
      for (std::size_t i = 0; i < grid.size(); ++i) {
        const double value = extended[i / grid.columns * stiffness.columns() + i % grid.columns];
        CHECK(std::abs(value - extended[0] - (displacement[i] - displacement[0])) < 1e-3 * scale);
      }
      stiffness.pressure(extended, extended, workspace);
      const double mean = extended_pressure[0] - extended[0];  // a uniform pressure on a periodic grid
      for (std::size_t i = 0; i < extended.size(); ++i) {
        CHECK(std::abs(extended[i] + mean - extended_pressure[i]) < round_off);
      }
      CHECK((periodic || std::abs(mean) < round_off));
    }
  }
}

TEST_CASE("StiffnessKernel: rejects an empty grid and a modulus of 0") {
  CHECK_THROWS_AS(StiffnessKernel(Grid{0, 4, 0.1, 0.1, false, false}, modulus), std::invalid_argument);
  CHECK_THROWS_AS(StiffnessKernel(area(false), 0.0), std::invalid_argument);
}
