#include "stiction/candidates.hpp"
#include "stiction/contact.hpp"
#include "stiction/detection.hpp"
#include "stiction/loading.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>
#include <vector>

namespace {

std::vector<double> sinusoid(std::size_t size) {
  std::vector<double> heights(size);
  for (std::size_t i = 0; i < size; ++i) {
    const double x = 0.01 * static_cast<double>(i) + 0.303;
    heights[i] = 0.02 * std::cos(2.0 * std::numbers::pi * x) + 1e-3 * x + 2e-4 * std::sin(40.0 * x);
  }
  return heights;
}

struct Cancelled {};

}  // namespace

TEST_CASE("gap_minimum: finds the minimum of a parabola and no other stationary point") {
  // The gap has the slope g' = 2 (t - 0.3), which is -0.6 at t = 0 and 1.4 at t = 1.
  CHECK(*stiction::gap_minimum(-0.6, 2.0, 1.4, 2.0, 1.0) == doctest::Approx(0.3).epsilon(1e-15));
  CHECK_FALSE(stiction::gap_minimum(0.6, -2.0, -1.4, -2.0, 1.0).has_value());
  CHECK_FALSE(stiction::gap_minimum(0.6, 2.0, 2.6, 2.0, 1.0).has_value());
  CHECK(*stiction::gap_minimum(0.0, 2.0, 2.0, 2.0, 1.0) == 0.0);
  CHECK_FALSE(stiction::gap_minimum(0.0, 2.0, 2.0, 2.0, 1.0, true).has_value());
}

TEST_CASE("ranges_within: the ranges contain every point within the given gap") {
  const std::vector<double> lower = sinusoid(1000);
  const std::vector<double> upper(lower.size(), 0.1);
  const stiction::Prefilter prefilter = stiction::run_prefilter(upper, lower);
  const double largest = 0.005;
  std::vector<bool> covered(lower.size(), false);
  for (const stiction::IndexRange& range : stiction::ranges_within(upper, lower, prefilter, largest)) {
    for (std::size_t i = range.begin; i < range.end; ++i) {
      covered[i] = true;
    }
  }
  for (std::size_t i = 0; i < lower.size(); ++i) {
    CHECK((covered[i] || upper[i] - lower[i] - prefilter.min_gap > largest));
  }
  CHECK(stiction::is_straight(upper, 0.1));
  CHECK_FALSE(stiction::is_straight(lower, 0.1));
}

TEST_CASE("press and contacts: stored candidates give bit-identical results") {
  const std::vector<double> lower = sinusoid(2000);
  const std::vector<double> upper(lower.size(), 0.1);
  const stiction::ProfilePair pair{upper, lower, 0.01};
  const stiction::ContactModel model{stiction::HertzSphere{10.0}, stiction::Detection::gap_minimum};
  const stiction::Candidates stored = stiction::candidates(pair, 0.05, model.curvature);
  CHECK(stored.all.size() >= 19);
  const std::vector<double> approaches{0.001, 0.01, 0.03};
  const auto from_stored = stiction::press(stored, approaches, model);
  const auto from_pair = stiction::press(pair, approaches, model);
  for (std::size_t k = 0; k < approaches.size(); ++k) {
    for (const stiction::Quantity& quantity : stiction::quantities) {
      std::visit([&](auto member) { CHECK(from_stored[k].*member == from_pair[k].*member); }, quantity.member);
    }
    CHECK(stiction::contacts(stored, approaches[k], model).size() ==
          static_cast<std::size_t>(from_pair[k].contact_count));
  }
  const double deeper = 0.06;
  CHECK_THROWS_AS(stiction::press(stored, {&deeper, 1}, model), std::invalid_argument);
}

TEST_CASE("approaches_at: the approach of a load reproduces the load") {
  const std::vector<double> lower = sinusoid(2000);
  const std::vector<double> upper(lower.size(), 0.1);
  const stiction::ProfilePair pair{upper, lower, 0.01};
  const stiction::ContactModel model{stiction::HertzSphere{10.0}, stiction::Detection::gap_minimum};
  const double approach = 0.01;
  const stiction::Sums sums = stiction::press(pair, {&approach, 1}, model).front();
  const double load = stiction::normal_load(sums, 0.3, 0.1);
  CHECK(load == sums.normal_elastic + 0.3 * sums.normal_frictional + 0.1 * sums.normal_adhesive);
  CHECK(stiction::status(sums, 0.3, 0.1) == stiction::Status::ok);
  CHECK(stiction::friction_coefficient(sums, 0.3, 0.1) == stiction::tangential_load(sums, 0.3, 0.1) / load);
  CHECK(stiction::status({}, 0.3) == stiction::Status::no_contact);
  CHECK(std::isnan(stiction::friction_coefficient({}, 0.3)));
  stiction::Sums locked;
  locked.contact_count = 1;
  locked.normal_frictional = -1.0;
  CHECK(stiction::status(locked, 0.3) == stiction::Status::self_locked);
  const double left = 0.001;
  const double right = 0.05;
  const auto back = stiction::approaches_at(pair, {&load, 1}, {&left, 1}, {&right, 1}, 0.3, 0.1, model);
  CHECK(back.front() == doctest::Approx(approach).epsilon(1e-9));
}

TEST_CASE("tangent: opposes the motion, in the plane of the motion and the normal") {
  for (const stiction::Vector2& direction : {stiction::Vector2(1.0, 0.0), stiction::Vector2(0.6, -0.8)}) {
    const stiction::Vector3 normal = stiction::Vector3(-0.2, 0.1, 1.0).normalized();
    const stiction::Vector3 tangent = stiction::tangent(normal, direction);
    CHECK(std::abs(tangent.dot(normal)) < 1e-15);
    CHECK(tangent.norm() == doctest::Approx(1.0).epsilon(1e-15));
    CHECK(tangent.head<2>().dot(direction) < 0.0);
  }
  // On a profile, the tangent is bit-identical to the normal (n_x, n_z) turned by 90 degrees.
  const stiction::Vector3 lean(0.28, 0.0, 0.96);
  CHECK(stiction::tangent(lean, {-1.0, 0.0}) == stiction::Vector3(0.96, 0.0, -0.28));
}

TEST_CASE("press: a cancellation check ends the calculation, and its exception is passed on") {
  const std::vector<double> lower = sinusoid(200000);
  const std::vector<double> upper(lower.size(), 0.1);
  const std::vector<double> approaches{0.05};
  const stiction::CancellationCheck end([] { throw Cancelled{}; });
  const stiction::ContactModel model{stiction::HertzSphere{10.0}};
  CHECK_THROWS_AS(stiction::press({upper, lower, 0.01}, approaches, model, end), Cancelled);
}

TEST_CASE("find_crossings: returns the argument just after a jump across the level") {
  const stiction::BatchFunction step = [](stiction::Values x) {
    std::vector<double> values;
    for (const double from_pair : x) {
      values.push_back(from_pair < 0.7 ? from_pair : from_pair + 1.0);
    }
    return values;
  };
  const std::vector<double> levels{0.3, 1.0};
  const std::vector<double> left{0.0, 0.0};
  const std::vector<double> right{1.0, 1.0};
  const auto roots = stiction::find_crossings(step, levels, left, right, 1e-12);
  CHECK(roots[0] == doctest::Approx(0.3).epsilon(1e-12));
  CHECK(roots[1] >= 0.7);
  CHECK(roots[1] == doctest::Approx(0.7).epsilon(1e-11));
}
