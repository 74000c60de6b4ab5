#include "stiction/half_space_contacts.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <numeric>
#include <span>
#include <stdexcept>
#include <vector>

using stiction::Grid;
using stiction::HalfSpaceGrids;
using stiction::HalfSpaceSolver;
using stiction::StepQuantity;

namespace {

constexpr double modulus = 10.0;
constexpr double tolerance = 1e-8;
constexpr double response_tolerance = 1e-12;
constexpr double infinite = std::numeric_limits<double>::infinity();
const std::vector<double> unbounded{infinite};
const Grid periodic_area{24, 32, 0.04, 0.05, false, true};

std::vector<double> make_gap(const Grid& grid) {
  std::vector<double> gap(grid.size());
  for (std::size_t i = 0; i < gap.size(); ++i) {
    const double x = static_cast<double>(i % grid.columns) / static_cast<double>(grid.columns);
    const double y = static_cast<double>(i / grid.columns) / static_cast<double>(grid.rows);
    gap[i] = 0.01 * (std::cos(6.28 * (x + 2 * y) + 1) + std::cos(18.8 * x) + 2);
  }
  return gap;
}

}  // namespace

TEST_CASE("solve_contacts: equals successive solutions, each started from the pressures before it") {
  const auto grids = std::make_shared<const HalfSpaceGrids>(periodic_area, modulus);
  const std::vector<double> gap = make_gap(periodic_area);
  const HalfSpaceSolver solver(gap, grids, unbounded, tolerance);
  const std::vector<double> loads = {0.01, 0.012, 0.05};
  std::vector<std::size_t> reported;
  const auto contacts =
      stiction::solve_contacts(solver, StepQuantity::mean_pressure, loads, {}, infinite, stiction::ThreadPool(),
                               [&](std::size_t step, std::int64_t iteration, double) {
                                 reported.resize(step + 1);
                                 reported[step] = static_cast<std::size_t>(iteration);
                               });
  REQUIRE(contacts.size() == loads.size());
  std::vector<double> near;
  for (std::size_t step = 0; step < loads.size(); ++step) {
    const auto solution = solver.at(loads[step], near);
    const auto patches = stiction::patches_of(solution.pressure, periodic_area, infinite);
    CHECK(contacts[step].patches.points == patches.points);
    CHECK(contacts[step].patches.pressure == patches.pressure);
    CHECK(contacts[step].approach == solution.approach);
    CHECK(contacts[step].iterations == solution.iterations);
    CHECK(reported[step] == static_cast<std::size_t>(solution.iterations));
    near = solution.pressure;
  }
}

TEST_CASE("solve_contacts: reaches the given approaches") {
  const auto grids = std::make_shared<const HalfSpaceGrids>(periodic_area, modulus);
  const std::vector<double> gap = make_gap(periodic_area);
  const HalfSpaceSolver solver(gap, grids, unbounded, tolerance);
  const auto contacts =
      stiction::solve_contacts(solver, StepQuantity::approach, std::vector<double>{0.005, 0.01}, {}, infinite);
  REQUIRE(contacts.size() == 2);
  CHECK(contacts[0].approach == doctest::Approx(0.005).epsilon(1e-6));
  CHECK(contacts[1].approach == doctest::Approx(0.01).epsilon(1e-6));
}

TEST_CASE("solve_contacts: stops at the first step without a solution") {
  const auto grids = std::make_shared<const HalfSpaceGrids>(periodic_area, modulus);
  const std::vector<double> gap = make_gap(periodic_area);
  const HalfSpaceSolver solver(gap, grids, unbounded, 1e-300);  // a tolerance that round-off makes unreachable
  const auto contacts =
      stiction::solve_contacts(solver, StepQuantity::mean_pressure, std::vector<double>{0.01, 0.02}, {}, infinite);
  REQUIRE(contacts.size() == 1);
  CHECK(contacts[0].error > solver.tolerance());
}

TEST_CASE("fixed_contact_responses: equal the linear responses of the contacts, also at full contact") {
  const HalfSpaceGrids grids(periodic_area, modulus);
  std::vector<std::int64_t> all(periodic_area.size());
  std::iota(all.begin(), all.end(), std::int64_t{0});
  const std::vector<std::int64_t> few = {3, 4, 40, 200};
  std::vector<double> weights(periodic_area.size());
  std::iota(weights.begin(), weights.end(), 1.0);
  const std::vector<std::span<const std::int64_t>> contacts = {few, all};
  const auto responses = stiction::fixed_contact_responses(grids, contacts, weights);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const auto marks = std::make_unique<bool[]>(weights.size());
    for (const std::int64_t point : contacts[i]) {
      marks[static_cast<std::size_t>(point)] = true;
    }
    const auto expected = stiction::linear_response(grids, {marks.get(), weights.size()});
    CHECK(responses[i].compliance == expected.compliance);
    CHECK(responses[i].weighted_displacement ==
          doctest::Approx(std::inner_product(weights.begin(), weights.end(), expected.pressure.begin(), 0.0))
              .epsilon(response_tolerance));
  }
  CHECK(responses[1].compliance == 0.0);
}

TEST_CASE("fixed_contact_responses: rejects empty contacts, points beyond the grid and weights of another size") {
  const HalfSpaceGrids grids(periodic_area, modulus);
  const std::vector<double> weights(periodic_area.size(), 1.0);
  const auto respond = [&](std::int64_t point, const std::vector<double>& displacement) {
    const std::vector<std::int64_t> points = {point};
    return stiction::fixed_contact_responses(grids, std::vector<std::span<const std::int64_t>>{points}, displacement);
  };
  CHECK_NOTHROW(respond(0, weights));
  CHECK_THROWS_AS(respond(-1, weights), std::invalid_argument);
  CHECK_THROWS_AS(respond(static_cast<std::int64_t>(periodic_area.size()), weights), std::invalid_argument);
  CHECK_THROWS_AS(respond(0, {1.0}), std::invalid_argument);
  CHECK_THROWS_AS(stiction::fixed_contact_responses(grids, std::vector<std::span<const std::int64_t>>{{}}, weights),
                  std::invalid_argument);
}
