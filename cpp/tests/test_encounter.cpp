#include "stiction/encounter.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <variant>

using stiction::Asperity;
using stiction::Curvature;
using stiction::Side;
using stiction::Touch;
using stiction::Vector3;
using stiction::Verdict;

namespace {
constexpr double round_off = 1e-13;

// A point of a sphere of this radius where its solid's outward normal leans by an angle from the vertical.
Asperity leaning(double angle, double radius, Side side) {
  const double up = side == Side::lower ? 1.0 : -1.0;
  return {up * Vector3(std::sin(angle), 0.0, std::cos(angle)), radius};
}
}  // namespace

TEST_CASE("Eq. 4: overlap, normal and centre of two spheres are those of their centres") {
  const double gap = 0.01;
  for (const double upper_radius : {2.0, -5.0}) {
    const Asperity above = leaning(0.02, upper_radius, Side::upper);
    const Asperity below = leaning(0.03, 3.0, Side::lower);
    const auto pair = stiction::sphere_pair(above, below, gap, Curvature::signed_);
    REQUIRE(pair.has_value());
    CHECK(1.0 / pair->radius == doctest::Approx(1.0 / upper_radius + 1.0 / 3.0).epsilon(round_off));
    for (const double approach : {0.0, 0.01, 0.1}) {
      const Vector3 lower_centre = below.centre_offset();
      const Vector3 upper_centre = above.centre_offset() + Vector3(0.0, 0.0, gap - approach);
      const Vector3 x = upper_centre - lower_centre;
      const double sign = upper_radius > 0.0 ? 1.0 : -1.0;
      const Touch touch = pair->at(approach);
      CHECK(pair->is_apart(approach) == !(touch.overlap > 0.0));
      CHECK(touch.normal.isApprox(sign / x.norm() * x, round_off));
      CHECK(touch.overlap == doctest::Approx(upper_radius + 3.0 - sign * x.norm()).epsilon(1e-10));
      const Vector3 centre = lower_centre + 0.5 * x - 0.5 * (upper_radius - 3.0) * touch.normal;
      CHECK((touch.centre - centre).norm() < round_off);
    }
  }
}

TEST_CASE("rule 3: what is not convex together is no pair, and a cup is one only where curvatures may be signed") {
  const Asperity ball = leaning(0.0, 2.0, Side::upper);
  CHECK(stiction::sphere_pair(ball, leaning(0.0, 3.0, Side::lower), 0.0, Curvature::convex).has_value());
  CHECK_FALSE(stiction::sphere_pair(ball, leaning(0.0, -3.0, Side::lower), 0.0, Curvature::convex).has_value());
  CHECK(stiction::sphere_pair(ball, leaning(0.0, -3.0, Side::lower), 0.0, Curvature::signed_).has_value());
  CHECK_FALSE(stiction::sphere_pair(ball, leaning(0.0, -1.0, Side::lower), 0.0, Curvature::signed_).has_value());
  CHECK_FALSE(stiction::sphere_on_straight(leaning(0.0, -1.0, Side::lower), Side::lower, ball, 0.0).has_value());
}

TEST_CASE("a sphere on a plane overlaps by the approach along the plane's normal") {
  const double tilt = 0.3;
  const Asperity sphere = leaning(tilt, 2.0, Side::lower);
  const auto on = stiction::sphere_on_straight(sphere, Side::lower, leaning(tilt, 0.0, Side::upper), 0.01);
  REQUIRE(on.has_value());
  const Touch touch = on->at(0.05);
  CHECK(touch.overlap == doctest::Approx((0.05 - 0.01) * std::cos(tilt)).epsilon(round_off));
  CHECK(touch.normal.isApprox(sphere.normal, round_off));
  CHECK(stiction::radii(*on).major == 2.0);
}

TEST_CASE("rules 1, 2 and 4 (Eq. 5): a cell is closed on its left and open on its right") {
  const Vector3 up(0.0, 0.0, 1.0);
  const auto at = [&](double x, double overlap, const Vector3& normal) {
    return stiction::judge({normal, Vector3(x, 0.0, 0.0), overlap}, 0.5);
  };
  CHECK(at(-0.5, 0.1, up) == Verdict::contact);
  CHECK(at(0.5, 0.1, up) == Verdict::no_contact);
  CHECK(at(0.0, 0.0, up) == Verdict::no_contact);
  CHECK(at(0.0, 0.1, -up) == Verdict::crossed);
  CHECK(at(0.0, std::nan(""), up) == Verdict::no_contact);
}

TEST_CASE("the mean radius of a sphere is its radius, to the bit, and of an ellipse the geometric mean") {
  for (const double radius : {0.1, 1.0 / 3.0, 1e-200, 1e200}) {
    CHECK(stiction::Radii{radius, radius}.mean() == radius);
  }
  CHECK(stiction::Radii{8.0, 2.0}.mean() == doctest::Approx(4.0).epsilon(round_off));
}
