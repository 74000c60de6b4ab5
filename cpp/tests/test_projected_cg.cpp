#include "stiction/projected_cg.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <vector>

using stiction::ProjectedCgSolver;

namespace {

constexpr double round_off = 1e-6;  // relative round-off of steps in single precision
const std::vector<double> none{std::numeric_limits<double>::infinity()};

// Independent springs: K p = p / stiffness.
struct Springs {
  std::vector<double> gap;
  double stiffness;

  ProjectedCgSolver solve(double total, std::vector<double> bound, bool line) const {
    ProjectedCgSolver solver(std::vector<double>(gap.size(), 1.0), total, bound, line);
    const auto recompute_potential = [&] {
      std::vector<double> potential(gap);
      for (std::size_t i = 0; i < gap.size(); ++i) {
        potential[i] += solver.pressure()[i] / stiffness;
      }
      solver.restart(potential);
    };
    recompute_potential();
    std::vector<float> response;
    for (int count = 0; count < 100 && solver.update_free_points() > 1e-9; ++count) {
      const auto residual = solver.residual();
      std::vector<float> preconditioned(residual.begin(), residual.end());
      for (float& value : preconditioned) {
        value *= static_cast<float>(stiffness);
      }
      const auto step = solver.step(preconditioned, response);
      response.assign(step.begin(), step.end());
      for (float& value : response) {
        value /= static_cast<float>(stiffness);
      }
      solver.advance(response);
      solver.rescale_to_total();
      recompute_potential();
      response.clear();
    }
    return solver;
  }
};

}  // namespace

TEST_CASE("ProjectedCgSolver: independent springs under pressure have equal potentials") {
  // The load of 10 closes three gaps. For a spring stiffness of 2, 2 (δ + (δ - 1) + (δ - 2)) = 10, so δ = 8/3.
  for (const bool line : {false, true}) {
    const auto solver = Springs{{0.0, 1.0, 2.0, 9.0}, 2.0}.solve(10.0, none, line);
    const std::array<double, 4> expected{16.0 / 3.0, 10.0 / 3.0, 4.0 / 3.0, 0.0};
    for (std::size_t i = 0; i < expected.size(); ++i) {
      CHECK(solver.pressure()[i] == doctest::Approx(expected[i]).epsilon(round_off));
    }
    CHECK(solver.approach() == doctest::Approx(8.0 / 3.0).epsilon(round_off));
    // At every point under pressure, the potential equals the approach 8/3.
    CHECK(solver.pressure_dot_potential() == doctest::Approx(10.0 * 8.0 / 3.0).epsilon(round_off));
  }
}

TEST_CASE("ProjectedCgSolver: a bound limits the pressure and other points carry the remaining load") {
  // Spring 1 carries its maximum load of 4. Springs 2 and 3 carry 2 ((δ - 1) + (δ - 2)) = 6, so the approach δ is 3.
  const auto solver = Springs{{0.0, 1.0, 2.0, 9.0}, 2.0}.solve(10.0, {4.0}, false);
  const std::array<double, 4> expected{4.0, 4.0, 2.0, 0.0};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    CHECK(solver.pressure()[i] == doctest::Approx(expected[i]).epsilon(round_off));
  }
}

TEST_CASE("ProjectedCgSolver: respects a separate bound for each point") {
  // The bounds limit the loads of springs 2 and 3 to 0 and 1. Springs 1 and 4 carry 2 (δ + (δ - 4)) = 9, so δ = 4.25.
  for (const bool line : {false, true}) {
    const auto solver = Springs{{0.0, 1.0, 2.0, 4.0}, 2.0}.solve(10.0, {100.0, 0.0, 1.0, 9.0}, line);
    const std::array<double, 4> expected{8.5, 0.0, 1.0, 0.5};
    for (std::size_t i = 0; i < expected.size(); ++i) {
      CHECK(solver.pressure()[i] == doctest::Approx(expected[i]).epsilon(round_off));
    }
    CHECK(solver.approach() == doctest::Approx(4.25).epsilon(round_off));
  }
}

TEST_CASE("ProjectedCgSolver: with the whole load at the bounds, the approach lies between the points") {
  const ProjectedCgSolver start(std::vector<double>{0.0, 1.0, 0.0}, 1.0, std::vector<double>{1.0}, false);
  ProjectedCgSolver solver = start;
  solver.restart(std::vector<double>{0.0, 5.0, 2.0});
  CHECK(solver.update_free_points() ==
        doctest::Approx(2.5));  // the approach lies midway between the loaded point and the point that overlaps most
  CHECK(solver.approach() == doctest::Approx(2.5));
  solver.restart(std::vector<double>{3.0, 1.0, 2.0});
  CHECK(solver.update_free_points() == 0.0);
  CHECK(solver.approach() == 1.0);
}

TEST_CASE("ProjectedCgSolver: steps in which all points reach their bounds preserve the load") {
  ProjectedCgSolver solver(std::vector<double>{0.5, 0.9, 0.1}, 1.5, std::vector<double>{1.0}, false);
  // Each step moves load from one of the first two points to the other. The optimal step length grows with each step.
  for (int count = 0; count < 100; ++count) {
    const bool odd = count % 2 == 1;
    solver.restart(std::vector<double>{odd ? 1.0 : 0.0, odd ? 0.0 : 1.0, 3.0});
    solver.update_free_points();
    const auto step = solver.step(solver.residual(), {});
    std::vector<float> response(step.begin(), step.end());
    for (float& value : response) {
      value *= 1e-6F;
    }
    solver.advance(response);
  }
  CHECK(std::accumulate(solver.pressure().begin(), solver.pressure().end(), 0.0) ==
        doctest::Approx(1.5).epsilon(1e-12));
}

TEST_CASE("ProjectedCgSolver: projects the initial pressure onto the bounds and the required sum") {
  const ProjectedCgSolver solver(std::vector<double>{0.0, 5.0, 1.0}, 4.0, std::vector<double>{2.5}, false);
  const auto pressure = solver.pressure();
  CHECK(std::accumulate(pressure.begin(), pressure.end(), 0.0) == doctest::Approx(4.0).epsilon(1e-14));
  CHECK(pressure[0] == 0.0);
  CHECK(pressure[1] == doctest::Approx(2.5));
}

TEST_CASE("ProjectedCgSolver: holds the points that a direction would push beyond their bounds") {
  // The mean potential of the four points is 1.4. It drives the pressures of points 0 and 3 away from their bounds.
  const std::vector<double> bound{3.0, 3.0, 3.0, 3.0};
  ProjectedCgSolver solver({0.0, 1.0, 1.0, 3.0}, 5.0, bound, false);
  solver.restart({0.8, 1.0, 2.0, 1.8});
  CHECK(solver.update_free_points() > 0.0);
  CHECK(solver.free_points().size() == 4);
  const auto residual = solver.residual();
  CHECK_FALSE(solver.hold_points_at_bounds(std::vector<float>{1.0F, 1.0F, -1.0F, -1.0F}));
  CHECK(solver.hold_points_at_bounds(std::vector<float>{-1.0F, 2.0F, -2.0F, 1.0F}));
  const std::vector<std::int32_t> free_points(solver.free_points().begin(), solver.free_points().end());
  CHECK(free_points == std::vector<std::int32_t>{1, 2});
  // The mean potential of points 1 and 2, which are not held, is 1.5.
  CHECK(std::vector<float>(residual.begin(), residual.end()) == std::vector<float>{0.0F, 0.5F, -0.5F, 0.0F});
  CHECK_FALSE(solver.hold_points_at_bounds(std::vector<float>{-1.0F, 2.0F, -2.0F, 1.0F}));
  ProjectedCgSolver line({1.0, 1.0}, 2.0, none, true);
  CHECK_THROWS_AS(line.hold_points_at_bounds(std::vector<float>(2)), std::logic_error);
}

TEST_CASE("ProjectedCgSolver: invalid arguments throw") {
  const std::vector<double> start{1.0, 1.0};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(ProjectedCgSolver({}, 1.0, none, false), std::invalid_argument);
  CHECK_THROWS_AS(ProjectedCgSolver(start, 0.0, none, false), std::invalid_argument);
  CHECK_THROWS_AS(ProjectedCgSolver(start, nan, none, false), std::invalid_argument);
  CHECK_THROWS_AS(ProjectedCgSolver(start, 2.0, std::vector<double>{1.0}, false), std::invalid_argument);
  CHECK_THROWS_AS(ProjectedCgSolver(start, 2.0, std::vector<double>{1.0, 1.0}, false), std::invalid_argument);
  CHECK_THROWS_AS(ProjectedCgSolver(start, 2.0, std::vector<double>{}, false), std::invalid_argument);
  CHECK_THROWS_AS(ProjectedCgSolver(start, 2.0, std::vector<double>{4.0, -1.0}, false), std::invalid_argument);
  CHECK_THROWS_AS(ProjectedCgSolver(start, 2.0, std::vector<double>{4.0, nan}, false), std::invalid_argument);
  ProjectedCgSolver solver(start, 1.0, none, false);
  CHECK_THROWS_AS(solver.update_free_points(), std::logic_error);
  CHECK_THROWS_AS(solver.restart(std::vector<double>{1.0}), std::invalid_argument);
  solver.restart(start);
  solver.update_free_points();
  CHECK_THROWS_AS(solver.step(std::vector<float>{1.0F}, {}), std::invalid_argument);
  CHECK_THROWS_AS(solver.advance(std::vector<float>{1.0F}), std::invalid_argument);
}
