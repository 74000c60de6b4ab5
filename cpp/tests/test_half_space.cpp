#include "stiction/half_space.hpp"

#include <Eigen/Cholesky>

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <thread>
#include <vector>

using stiction::Grid;
using stiction::HalfSpaceGrids;
using stiction::HalfSpaceSolution;
using stiction::HalfSpaceSolver;
using stiction::ThreadPool;

namespace {

constexpr double modulus = 10.0;
constexpr double tolerance = 1e-10;
constexpr double compliance_tolerance = 1e-6;
constexpr double pressure_tolerance = 5e-3;  // relative error of pressures; the energy has the square of this error
const std::vector<double> unbounded{std::numeric_limits<double>::infinity()};

std::vector<double> sinusoids(const Grid& grid) {
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

// Periodic heights that are the sum of 15 waves on maps, and of 30 waves on lines.
std::vector<double> periodic_surface(const Grid& grid) {
  std::vector<double> heights(grid.size(), 0.0);
  for (int wave = 1; wave <= (grid.line ? 30 : 15); ++wave) {
    const double number = grid.line ? wave : 1.5 + 0.6 * wave;
    const double x_number = std::round(number * std::cos(grid.line ? 0.0 : 2.4 * wave));
    const double y_number = std::round(number * std::sin(grid.line ? 0.0 : 2.4 * wave));
    const double frequency = 2 * std::numbers::pi * std::hypot(x_number, y_number);
    for (std::size_t i = 0; i < heights.size(); ++i) {
      const double x = static_cast<double>(i % grid.columns) / static_cast<double>(grid.columns);
      const double y = static_cast<double>(i / grid.columns) / static_cast<double>(grid.rows);
      heights[i] += 1.0 / (frequency * std::sqrt(frequency)) *
                    std::cos(2 * std::numbers::pi * (x_number * x + y_number * y) + wave * wave);
    }
  }
  return heights;
}

std::vector<double> rough_surface(const Grid& grid) {
  std::vector<double> heights(grid.size(), 0.0);
  for (int wave = 1; wave <= 60; ++wave) {
    const double frequency = 6.28 * (1.5 + 0.6 * wave);
    const double direction = 2.4 * wave;
    for (std::size_t i = 0; i < heights.size(); ++i) {
      const double x = static_cast<double>(i % grid.columns) / static_cast<double>(grid.columns);
      const double y = static_cast<double>(i / grid.columns) / static_cast<double>(grid.rows);
      heights[i] += 1.0 / (frequency * std::sqrt(frequency)) *
                    std::cos(frequency * (x * std::cos(direction) + y * std::sin(direction)) + wave * wave);
    }
  }
  return heights;
}

// Points under pressure must not have a gap, and only points at their pressure bound may overlap.
void check_contact_conditions(const HalfSpaceGrids& grids, const std::vector<double>& gap,
                              const std::vector<double>& bound, double mean, double unit,
                              const HalfSpaceSolution& solution) {
  const std::size_t size = gap.size();
  stiction::Workspace workspace;
  std::vector<double> displacement(size);
  grids.kernels().points->displacement(solution.pressure, displacement, workspace);
  double max_violation = 0.0;
  for (std::size_t i = 0; i < size; ++i) {
    const double remaining_gap = displacement[i] + gap[i] - solution.approach;
    const double upper_bound = bound.size() == 1 ? bound[0] : bound[i];
    CHECK(solution.pressure[i] >= 0.0);
    CHECK(solution.pressure[i] <= upper_bound);
    max_violation = std::max(max_violation, solution.pressure[i] > 0.0 ? remaining_gap : 0.0);
    max_violation = std::max(max_violation, solution.pressure[i] < upper_bound ? -remaining_gap : 0.0);
  }
  CHECK(max_violation <= 2 * tolerance * unit);
  CHECK(std::accumulate(solution.pressure.begin(), solution.pressure.end(), 0.0) / static_cast<double>(size) ==
        doctest::Approx(mean).epsilon(1e-9));
}

}  // namespace

TEST_CASE("HalfSpaceSolver: satisfies the contact conditions on lines and areas for all kinds of bounds") {
  for (const bool periodic : {true, false}) {
    for (const Grid& grid : {Grid{1, 63, 1.0, 0.02, true, periodic}, Grid{1, 200, 1.0, 0.01, true, periodic},
                             Grid{33, 50, 0.05, 0.04, false, periodic}}) {
      const auto grids = std::make_shared<const HalfSpaceGrids>(grid, modulus);
      const std::vector<double> gap = sinusoids(grid);
      std::vector<double> uneven(grid.size());
      for (std::size_t i = 0; i < uneven.size(); ++i) {
        uneven[i] = i % 7 == 0 ? 0.0 : 0.1 + 0.01 * static_cast<double>(i % 5);
      }
      for (const std::vector<double>& bound : {unbounded, std::vector<double>{0.2}, uneven}) {
        const HalfSpaceSolver solver(gap, grids, bound, tolerance);
        std::vector<double> near;
        for (const double mean : {0.01, 0.05, 0.06}) {
          const HalfSpaceSolution solution = solver.at(mean, near);
          REQUIRE(solution.error <= tolerance);
          check_contact_conditions(*grids, gap, bound, mean, solver.scale(mean), solution);
          near = solution.pressure;
        }
      }
    }
  }
}

TEST_CASE("HalfSpaceGrids: pressures on a free area displace all points in the direction of the load") {
  for (const Grid& grid : {Grid{64, 64, 0.05, 0.05, false, false}, Grid{3, 200, 0.5, 0.01, false, false}}) {
    const HalfSpaceGrids grids(grid, modulus);
    const auto influence = grids.influence();
    CHECK(*std::min_element(influence.begin(), influence.end()) > 0.0);
  }
}

// Except at the highest loads, displacements are computed only at the few points that can come into contact.
TEST_CASE("HalfSpaceSolver: satisfies the contact conditions on the whole grid if few points can come into contact") {
  const Grid grid{96, 80, 0.05, 0.06, false, false};
  const auto grids = std::make_shared<const HalfSpaceGrids>(grid, modulus);
  const std::vector<double> gap = rough_surface(grid);
  std::vector<double> uneven(grid.size());
  std::vector<double> misplaced(grid.size(), 0.0);  // pressures on every 97th point, regardless of the gap at the point
  for (std::size_t i = 0; i < gap.size(); ++i) {
    uneven[i] = i % 5 == 0 ? 0.0 : 0.4 + 0.1 * static_cast<double>(i % 3);
    misplaced[i] = i % 97 == 0 ? 0.01 : 0.0;
  }
  std::ptrdiff_t max_loaded = 0;
  // If each point has its own pressure bound, the solver always starts from the pressures that it is given.
  for (const std::vector<double>& bound :
       {unbounded, std::vector<double>{0.5}, std::vector<double>(grid.size(), 0.5), uneven}) {
    const HalfSpaceSolver solver(gap, grids, bound, tolerance);
    for (const double mean : {3e-4, 1e-3, 3e-3, 0.01, 0.02, 0.05}) {
      const std::vector<double> from_coarse_grids;
      for (const std::vector<double>& near : {from_coarse_grids, solver.at(0.8 * mean).pressure, misplaced}) {
        const HalfSpaceSolution solution = solver.at(mean, near);
        REQUIRE(solution.error <= tolerance);
        check_contact_conditions(*grids, gap, bound, mean, solver.scale(mean), solution);
        max_loaded = std::max(max_loaded, std::count_if(solution.pressure.begin(), solution.pressure.end(),
                                                        [](double pressure) { return pressure > 0.0; }));
      }
    }
  }
  CHECK(max_loaded > 400);  // at the highest loads, too many points come into contact for a selection
}

TEST_CASE("HalfSpaceSolver: finds points that come into contact only at a larger approach than at the start") {
  const Grid grid{64, 64, 0.05, 0.05, false, false};
  const auto grids = std::make_shared<const HalfSpaceGrids>(grid, modulus);
  std::vector<double> gap(grid.size(), 1.0);
  std::vector<double> bound(grid.size(), 10.0);
  std::vector<double> start(grid.size(), 0.0);
  for (std::size_t i = 0; i < 20; ++i) {
    gap[211 * i] = 0.0;  // summits, which carry little load at the start
    start[211 * i] = 0.001;
    gap[211 * i + 20] = 0.0005;  // summits that come into contact later
    for (const std::size_t high : {211 * i + 50, 211 * i + 60}) {
      gap[high] = 0.003;  // points that stay out of contact, but carry most of the load at the start
      start[high] = bound[high] = 0.1;
    }
  }
  const double mean = 1.01 * std::accumulate(start.begin(), start.end(), 0.0) / static_cast<double>(grid.size());
  const HalfSpaceSolver solver(gap, grids, bound, tolerance);
  const HalfSpaceSolution solution = solver.at(mean, start);
  REQUIRE(solution.error <= tolerance);
  check_contact_conditions(*grids, gap, bound, mean, solver.scale(mean), solution);
  CHECK(std::count_if(solution.pressure.begin(), solution.pressure.end(), [](double p) { return p > 0.0; }) == 40);
  CHECK(solution.iterations < 10);  // more iterations would be needed if the potential or the response were not reset
}

TEST_CASE("HalfSpaceSolver: edges of contacts that are extrapolated from coarser grids save iterations") {
  constexpr std::array loads{0.005, 0.01, 0.03, 0.05, 0.1};
  // If pressures were interpolated linearly at contact edges, the three grids would need 57, 59 and 60 iterations.
  constexpr std::int64_t max_iterations = 54;
  for (const Grid& grid :
       {Grid{256, 256, 1.0 / 256, 1.0 / 256, false, true}, Grid{255, 240, 1.0 / 255, 1.0 / 240, false, true},
        Grid{1, 4096, 1.0, 1.0 / 4096, true, true}}) {
    const std::vector<double> gap = periodic_surface(grid);
    const HalfSpaceSolver solver(gap, std::make_shared<const HalfSpaceGrids>(grid, modulus), unbounded, 1e-6);
    std::int64_t iterations = 0;
    for (const double load : loads) {
      const HalfSpaceSolution solution = solver.at(load);
      CHECK(solution.error <= 1e-6);
      iterations += solution.iterations;
    }
    CHECK(iterations <= max_iterations);
  }
}

TEST_CASE("HalfSpaceSolver: solutions are bit-identical for any number of threads") {
  for (const bool periodic : {false, true}) {
    const Grid grid{500, 480, 0.005, 0.005, false, periodic};
    const auto grids = std::make_shared<const HalfSpaceGrids>(grid, modulus);
    const std::vector<double> gap = sinusoids(grid);
    const std::vector<double> bound{periodic ? 1.0 : unbounded[0]};
    const HalfSpaceSolver solver(gap, grids, bound, 1e-6);
    const HalfSpaceSolution alone = solver.at(0.4);
    const auto loaded = std::count_if(alone.pressure.begin(), alone.pressure.end(), [](double p) { return p > 0.0; });
    CHECK(loaded > 1 << 16);  // enough points for several tasks, which are distributed over the threads
    for (const std::size_t threads : {2U, 3U}) {
      const HalfSpaceSolution together = solver.at(0.4, {}, ThreadPool(threads));
      CHECK(together.pressure == alone.pressure);
      CHECK(together.approach == alone.approach);
    }
  }
}

TEST_CASE("HalfSpaceGrids: calculations reuse memory one after the other, and do not share it at the same time") {
  const HalfSpaceGrids grids(Grid{8, 8, 0.1, 0.1, false, true}, modulus);
  auto first = grids.borrow_memory();
  const auto* const address = first.get();
  CHECK(grids.borrow_memory().get() != address);
  first.reset();
  CHECK(grids.borrow_memory().get() == address);
}

TEST_CASE("HalfSpaceSolver: solutions are bit-identical after other calculations on the same grid") {
  for (const bool periodic : {false, true}) {
    const Grid grid{70, 90, 0.02, 0.02, false, periodic};
    const std::vector<double> gap = rough_surface(grid);
    const auto solve = [&](const std::shared_ptr<const HalfSpaceGrids>& grids, double load) {
      return HalfSpaceSolver(gap, grids, unbounded, 1e-6).at(load);
    };
    const auto response = [&](const HalfSpaceGrids& grids) {
      const auto free = std::make_unique<bool[]>(grid.size());
      std::fill_n(free.get(), grid.size() / 2, true);
      return stiction::linear_response(grids, {free.get(), grid.size()});
    };
    const auto used = std::make_shared<const HalfSpaceGrids>(grid, modulus);
    solve(used, 2.0);
    response(*used);
    CHECK(solve(used, 0.3).pressure == solve(std::make_shared<const HalfSpaceGrids>(grid, modulus), 0.3).pressure);
    CHECK(response(*used).pressure == response(HalfSpaceGrids(grid, modulus)).pressure);
  }
}

TEST_CASE("HalfSpaceSolver: concurrent threads with the same grids obtain the results of a single thread") {
  const Grid grid{40, 60, 0.1, 0.1, false, false};
  const std::vector<double> gap = sinusoids(grid);
  const auto solve = [&](const std::shared_ptr<const HalfSpaceGrids>& grids, std::size_t task) {
    return HalfSpaceSolver(gap, grids, unbounded, 1e-6).at(0.05 * static_cast<double>(task + 1));
  };
  const auto shared = std::make_shared<const HalfSpaceGrids>(grid, modulus);
  std::array<HalfSpaceSolution, 4> together;
  std::vector<std::thread> threads;
  for (std::size_t task = 0; task < together.size(); ++task) {
    threads.emplace_back([&, task] { together[task] = solve(shared, task); });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  for (std::size_t task = 0; task < together.size(); ++task) {
    CHECK(together[task].pressure == solve(std::make_shared<const HalfSpaceGrids>(grid, modulus), task).pressure);
  }
}

TEST_CASE("HalfSpaceSolver: solutions with a bound for each point contain the potential of points that can touch") {
  for (const bool periodic : {false, true}) {
    const Grid grid{40, 60, 0.1, 0.1, false, periodic};
    const auto grids = std::make_shared<const HalfSpaceGrids>(grid, modulus);
    const std::vector<double> gap(grid.size(), 0.0);
    std::vector<double> bound(grid.size(), 0.0);
    for (std::size_t i = 0; i < 100; ++i) {
      bound[7 * i] = 2.0;
    }
    const HalfSpaceSolution solution = HalfSpaceSolver(gap, grids, bound, tolerance).at(0.02);
    std::vector<double> displacements(grid.size());
    grids->displacement(solution.pressure, displacements);
    REQUIRE(solution.potential.size() == 100);
    for (std::size_t i = 0; i < 100; ++i) {
      CHECK(solution.potential[i] == doctest::Approx(displacements[7 * i]).epsilon(tolerance));
    }
    CHECK(HalfSpaceSolver(gap, grids, unbounded, tolerance).at(0.02).potential.empty());
  }
}

TEST_CASE("HalfSpaceSolver: at_approach reaches the requested approach") {
  const Grid grid{24, 20, 0.05, 0.05, false, true};
  const auto grids = std::make_shared<const HalfSpaceGrids>(grid, modulus);
  const std::vector<double> gap = sinusoids(grid);
  const HalfSpaceSolver solver(gap, grids, unbounded, 1e-8);
  const double lowest = *std::min_element(gap.begin(), gap.end());
  std::vector<double> above(gap);
  for (double& first : above) {
    first -= lowest;
  }
  const HalfSpaceSolver raised(above, grids, unbounded, 1e-8);
  const HalfSpaceSolution solution = raised.at_approach(0.005);
  CHECK(solution.error <= 1e-8);
  CHECK(solution.approach == doctest::Approx(0.005).epsilon(1e-6));
}

TEST_CASE("linear_response: matches the dense matrix for few and many points") {
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
          const std::size_t first = points[static_cast<std::size_t>(i)];
          const std::size_t second = points[static_cast<std::size_t>(j)];
          const auto distance = [](std::size_t a, std::size_t b) { return a > b ? a - b : b - a; };
          matrix(i, j) = influence[distance(first / grid.columns, second / grid.columns) * grid.columns +
                                   distance(first % grid.columns, second % grid.columns)];
        }
      }
      const Eigen::VectorXd even = matrix.ldlt().solve(Eigen::VectorXd::Ones(size));
      REQUIRE(even.minCoeff() > 0.0);
      const stiction::LinearResponse solution = stiction::linear_response(grids, {free.get(), grid.size()});
      CHECK(solution.compliance == doctest::Approx(1.0 / even.sum()).epsilon(compliance_tolerance));
      double difference = 0.0;
      for (Eigen::Index i = 0; i < size; ++i) {
        const double pressure = solution.pressure[points[static_cast<std::size_t>(i)]];
        difference = std::max(difference, std::abs(pressure * even.sum() - even[i]));
      }
      CHECK(difference < pressure_tolerance * even.maxCoeff());
      CHECK(std::accumulate(solution.pressure.begin(), solution.pressure.end(), 0.0) == doctest::Approx(1.0));
    }
  }
  const HalfSpaceGrids grids(Grid{8, 8, 0.1, 0.1, false, true}, modulus);
  std::array<bool, 64> all{};
  CHECK_THROWS_AS(stiction::linear_response(grids, all), std::invalid_argument);
  all.fill(true);
  CHECK(stiction::linear_response(grids, all).compliance == 0.0);
}

TEST_CASE("HalfSpaceSolver: invalid arguments throw, and the progress callback can cancel") {
  const Grid grid{1, 40, 1.0, 0.1, true, true};
  const auto grids = std::make_shared<const HalfSpaceGrids>(grid, modulus);
  const std::vector<double> gap = sinusoids(grid);
  const std::vector<double> short_gap(39);
  CHECK_THROWS_AS(HalfSpaceSolver(short_gap, grids, unbounded, tolerance), std::invalid_argument);
  CHECK_THROWS_AS(HalfSpaceSolver(gap, grids, short_gap, tolerance), std::invalid_argument);
  CHECK_THROWS_AS(HalfSpaceSolver(gap, grids, unbounded, 0.0), std::invalid_argument);
  const HalfSpaceSolver solver(gap, grids, unbounded, tolerance);
  CHECK_THROWS_AS(solver.at(-1.0), std::invalid_argument);
  CHECK_THROWS_AS(solver.at(0.1, short_gap), std::invalid_argument);
  const auto stop = [](std::int64_t, double) { throw std::length_error("stop"); };
  CHECK_THROWS_AS(solver.at(0.1, {}, ThreadPool(), stop), std::length_error);
}
