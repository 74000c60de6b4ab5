#include "stiction/pressure_search.hpp"

#include <doctest/doctest.h>

#include <array>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <vector>

using stiction::PressureSearch;

namespace {

constexpr double round_off = 1e-6;  // of steps in single precision
const std::vector<double> none{std::numeric_limits<double>::infinity()};

// Springs side by side: K p = p / stiffness, whose best preconditioner is the stiffness itself.
struct Springs {
  std::vector<double> gap;
  double stiffness;

  PressureSearch pressed(double total, std::vector<double> bound, bool line) const {
    PressureSearch search(std::vector<double>(gap.size(), 1.0), total, bound, line);
    const auto exact = [&] {
      std::vector<double> potential(gap);
      for (std::size_t i = 0; i < gap.size(); ++i) {
        potential[i] += search.pressure()[i] / stiffness;
      }
      search.restart(potential);
    };
    exact();
    std::vector<float> response;
    for (int count = 0; count < 100 && search.balance() > 1e-9; ++count) {
      const auto residual = search.residual();
      std::vector<float> preconditioned(residual.begin(), residual.end());
      for (float& value : preconditioned) {
        value *= static_cast<float>(stiffness);
      }
      const auto step = search.step(preconditioned, response);
      response.assign(step.begin(), step.end());
      for (float& value : response) {
        value /= static_cast<float>(stiffness);
      }
      search.advance(response);
      search.settle();
      exact();
      response.clear();
    }
    return search;
  }
};

}  // namespace

TEST_CASE("springs are pressed to one level") {
  // Gaps 0, 1, 2, 9 and stiffness 2 under a load of 10: (δ + δ - 1 + δ - 2) 2 = 10 gives δ = 8/3.
  for (const bool line : {false, true}) {
    const auto search = Springs{{0.0, 1.0, 2.0, 9.0}, 2.0}.pressed(10.0, none, line);
    const std::array<double, 4> expected{16.0 / 3.0, 10.0 / 3.0, 4.0 / 3.0, 0.0};
    for (std::size_t i = 0; i < expected.size(); ++i) {
      CHECK(search.pressure()[i] == doctest::Approx(expected[i]).epsilon(round_off));
    }
    CHECK(search.approach() == doctest::Approx(8.0 / 3.0).epsilon(round_off));
    // Every point under pressure has the potential of the approach.
    CHECK(search.work() == doctest::Approx(10.0 * 8.0 / 3.0).epsilon(round_off));
  }
}

TEST_CASE("the hardness caps the pressure and others bear the rest") {
  // The first spring bears 4; (δ - 1 + δ - 2) 2 = 6 gives δ = 3.
  const auto search = Springs{{0.0, 1.0, 2.0, 9.0}, 2.0}.pressed(10.0, {4.0}, false);
  const std::array<double, 4> expected{4.0, 4.0, 2.0, 0.0};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    CHECK(search.pressure()[i] == doctest::Approx(expected[i]).epsilon(round_off));
  }
}

TEST_CASE("each point has a bound of its own") {
  // The second bears nothing and the third 1: (δ + δ - 4) 2 = 9 gives δ = 4.25, over which the others' gaps overlap.
  for (const bool line : {false, true}) {
    const auto search = Springs{{0.0, 1.0, 2.0, 4.0}, 2.0}.pressed(10.0, {100.0, 0.0, 1.0, 9.0}, line);
    const std::array<double, 4> expected{8.5, 0.0, 1.0, 0.5};
    for (std::size_t i = 0; i < expected.size(); ++i) {
      CHECK(search.pressure()[i] == doctest::Approx(expected[i]).epsilon(round_off));
    }
    CHECK(search.approach() == doctest::Approx(4.25).epsilon(round_off));
  }
}

TEST_CASE("load that is all at the bounds, and at wrong points, finds the right ones") {
  const PressureSearch start(std::vector<double>{0.0, 1.0, 0.0}, 1.0, std::vector<double>{1.0}, false);
  PressureSearch search = start;
  search.restart(std::vector<double>{0.0, 5.0, 2.0});
  CHECK(search.balance() ==
        doctest::Approx(2.5));  // midway between the point that bears and the one that overlaps most
  CHECK(search.approach() == doctest::Approx(2.5));
  search.restart(std::vector<double>{3.0, 1.0, 2.0});
  CHECK(search.balance() == 0.0);
  CHECK(search.approach() == 1.0);
}

TEST_CASE("steps that all meet the bounds keep the load") {
  PressureSearch search(std::vector<double>{0.5, 0.9, 0.1}, 1.5, std::vector<double>{1.0}, false);
  // The gap calls for one point and then for the other, and hardly yields: steps want to be longer each time.
  for (int count = 0; count < 100; ++count) {
    const bool odd = count % 2 == 1;
    search.restart(std::vector<double>{odd ? 1.0 : 0.0, odd ? 0.0 : 1.0, 3.0});
    search.balance();
    const auto step = search.step(search.residual(), {});
    std::vector<float> response(step.begin(), step.end());
    for (float& value : response) {
      value *= 1e-6F;
    }
    search.advance(response);
  }
  CHECK(std::accumulate(search.pressure().begin(), search.pressure().end(), 0.0) ==
        doctest::Approx(1.5).epsilon(1e-12));
}

TEST_CASE("a start is brought to the bounds and the sum") {
  const PressureSearch search(std::vector<double>{0.0, 5.0, 1.0}, 4.0, std::vector<double>{2.5}, false);
  const auto pressure = search.pressure();
  CHECK(std::accumulate(pressure.begin(), pressure.end(), 0.0) == doctest::Approx(4.0).epsilon(1e-14));
  CHECK(pressure[0] == 0.0);
  CHECK(pressure[1] == doctest::Approx(2.5));
}

TEST_CASE("what cannot be is refused") {
  const std::vector<double> one{1.0, 1.0};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(PressureSearch({}, 1.0, none, false), std::invalid_argument);
  CHECK_THROWS_AS(PressureSearch(one, 0.0, none, false), std::invalid_argument);
  CHECK_THROWS_AS(PressureSearch(one, nan, none, false), std::invalid_argument);
  CHECK_THROWS_AS(PressureSearch(one, 2.0, std::vector<double>{1.0}, false), std::invalid_argument);
  CHECK_THROWS_AS(PressureSearch(one, 2.0, std::vector<double>{1.0, 1.0}, false), std::invalid_argument);
  CHECK_THROWS_AS(PressureSearch(one, 2.0, std::vector<double>{}, false), std::invalid_argument);
  CHECK_THROWS_AS(PressureSearch(one, 2.0, std::vector<double>{4.0, -1.0}, false), std::invalid_argument);
  CHECK_THROWS_AS(PressureSearch(one, 2.0, std::vector<double>{4.0, nan}, false), std::invalid_argument);
  PressureSearch search(one, 1.0, none, false);
  CHECK_THROWS_AS(search.balance(), std::logic_error);
  CHECK_THROWS_AS(search.restart(std::vector<double>{1.0}), std::invalid_argument);
  search.restart(one);
  search.balance();
  CHECK_THROWS_AS(search.step(std::vector<float>{1.0F}, {}), std::invalid_argument);
  CHECK_THROWS_AS(search.advance(std::vector<float>{1.0F}), std::invalid_argument);
}
