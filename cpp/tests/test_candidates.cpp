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

// Waves of a length of 1 µm above a flat body.
std::vector<double> waves(std::size_t size) {
  std::vector<double> heights(size);
  for (std::size_t i = 0; i < size; ++i) {
    const double x = 0.01 * static_cast<double>(i) + 0.303;
    heights[i] = 0.02 * std::cos(2.0 * std::numbers::pi * x) + 1e-3 * x + 2e-4 * std::sin(40.0 * x);
  }
  return heights;
}

struct Ended {};

}  // namespace

TEST_CASE("gap minima of a parabola, and of none") {
  // g' = 2 (t - 0.3): slopes -0.6 and 1.4 at the ends of [0, 1).
  CHECK(*stiction::gap_minimum(-0.6, 2.0, 1.4, 2.0, 1.0) == doctest::Approx(0.3).epsilon(1e-15));
  CHECK_FALSE(stiction::gap_minimum(0.6, -2.0, -1.4, -2.0, 1.0).has_value());  // a maximum
  CHECK_FALSE(stiction::gap_minimum(0.6, 2.0, 2.6, 2.0, 1.0).has_value());     // beyond
  CHECK(*stiction::gap_minimum(0.0, 2.0, 2.0, 2.0, 1.0) == 0.0);
  CHECK_FALSE(stiction::gap_minimum(0.0, 2.0, 2.0, 2.0, 1.0, true).has_value());  // ends are never minima
}

TEST_CASE("stretches hold every point that is near enough") {
  const std::vector<double> lower = waves(1000);
  const std::vector<double> upper(lower.size(), 0.1);
  const stiction::Screening screening = stiction::screen(upper, lower);
  const double largest = 0.005;
  std::vector<bool> held(lower.size(), false);
  for (const stiction::Stretch& stretch : stiction::stretches_within(upper, lower, screening, largest)) {
    for (std::size_t i = stretch.begin; i < stretch.end; ++i) {
      held[i] = true;
    }
  }
  for (std::size_t i = 0; i < lower.size(); ++i) {
    CHECK((held[i] || upper[i] - lower[i] - screening.gap > largest));
  }
  CHECK(stiction::is_straight(upper, 0.1));
  CHECK_FALSE(stiction::is_straight(lower, 0.1));
}

TEST_CASE("candidates found once give the same sums and contacts, to the bit, as those found at each press") {
  const std::vector<double> lower = waves(2000);
  const std::vector<double> upper(lower.size(), 0.1);
  const stiction::ProfilePair pair{upper, lower, 0.01};
  const stiction::ContactModel model{stiction::HertzSphere{10.0}, stiction::Detection::gap_minimum};
  const stiction::Candidates found = stiction::candidates(pair, 0.05, model.curvature);
  CHECK(found.all.size() >= 19);
  const std::vector<double> approaches{0.001, 0.01, 0.03};
  const auto once = stiction::press(found, approaches, model);
  const auto each = stiction::press(pair, approaches, model);
  for (std::size_t k = 0; k < approaches.size(); ++k) {
    for (const stiction::Quantity& quantity : stiction::quantities) {
      std::visit([&](auto member) { CHECK(once[k].*member == each[k].*member); }, quantity.member);
    }
    CHECK(stiction::contacts(found, approaches[k], model).size() == static_cast<std::size_t>(each[k].contact_count));
  }
  const double deeper = 0.06;
  CHECK_THROWS_AS(stiction::press(found, {&deeper, 1}, model), std::invalid_argument);
}

TEST_CASE("loads are those of the sums, and a load's approach carries it") {
  const std::vector<double> lower = waves(2000);
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

TEST_CASE("tangents lie against the motion, in its plane with the normal") {
  for (const stiction::Vector2& direction : {stiction::Vector2(1.0, 0.0), stiction::Vector2(0.6, -0.8)}) {
    const stiction::Vector3 normal = stiction::Vector3(-0.2, 0.1, 1.0).normalized();
    const stiction::Vector3 tangent = stiction::tangent(normal, direction);
    CHECK(std::abs(tangent.dot(normal)) < 1e-15);
    CHECK(tangent.norm() == doctest::Approx(1.0).epsilon(1e-15));
    CHECK(tangent.head<2>().dot(direction) < 0.0);
  }
  // σ (-n_z, n_x) on a profile, to the bit.
  const stiction::Vector3 lean(0.28, 0.0, 0.96);
  CHECK(stiction::tangent(lean, {-1.0, 0.0}) == stiction::Vector3(0.96, 0.0, -0.28));
}

TEST_CASE("a checkpoint ends a press, and passes on what it throws") {
  const std::vector<double> lower = waves(200000);
  const std::vector<double> upper(lower.size(), 0.1);
  const std::vector<double> approaches{0.05};
  const stiction::Checkpoint end([] { throw Ended{}; });
  const stiction::ContactModel model{stiction::HertzSphere{10.0}};
  CHECK_THROWS_AS(stiction::press({upper, lower, 0.01}, approaches, model, end), Ended);
}

TEST_CASE("a function that jumps over a level is followed to the argument behind the jump") {
  const stiction::ManyValues step = [](stiction::Values x) {
    std::vector<double> values;
    for (const double each : x) {
      values.push_back(each < 0.7 ? each : each + 1.0);
    }
    return values;
  };
  const std::vector<double> levels{0.3, 1.0};
  const std::vector<double> left{0.0, 0.0};
  const std::vector<double> right{1.0, 1.0};
  const auto roots = stiction::rises_through(step, levels, left, right, 1e-12);
  CHECK(roots[0] == doctest::Approx(0.3).epsilon(1e-12));
  CHECK(roots[1] >= 0.7);
  CHECK(roots[1] == doctest::Approx(0.7).epsilon(1e-11));
}
