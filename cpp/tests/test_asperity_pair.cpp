#include "stiction/asperity_pair.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <variant>

using stiction::Asperity;
using stiction::ContactClass;
using stiction::ContactPoint;
using stiction::Curvature;
using stiction::Side;
using stiction::Vector3;

namespace {
constexpr double round_off = 1e-13;

Asperity inclined_asperity(double angle, double radius, Side side) {
  const double up = side == Side::lower ? 1.0 : -1.0;
  return {up * Vector3(std::sin(angle), 0.0, std::cos(angle)), radius};
}
}  // namespace

TEST_CASE("SpherePair: overlap, normal and centre match the vector between the sphere centres (Eq. 4)") {
  const double gap = 0.01;
  for (const double upper_radius : {2.0, -5.0}) {
    const Asperity above = inclined_asperity(0.02, upper_radius, Side::upper);
    const Asperity below = inclined_asperity(0.03, 3.0, Side::lower);
    const auto pair = stiction::sphere_pair(above, below, gap, Curvature::signed_);
    REQUIRE(pair.has_value());
    CHECK(1.0 / pair->radius == doctest::Approx(1.0 / upper_radius + 1.0 / 3.0).epsilon(round_off));
    for (const double approach : {0.0, 0.01, 0.1}) {
      const Vector3 lower_centre = below.centre_offset();
      const Vector3 upper_centre = above.centre_offset() + Vector3(0.0, 0.0, gap - approach);
      const Vector3 x = upper_centre - lower_centre;
      const double sign = upper_radius > 0.0 ? 1.0 : -1.0;
      const ContactPoint contact_point = pair->contact_at(approach);
      CHECK(pair->is_separated(approach) == !(contact_point.overlap > 0.0));
      CHECK(contact_point.normal.isApprox(sign / x.norm() * x, round_off));
      CHECK(contact_point.overlap == doctest::Approx(upper_radius + 3.0 - sign * x.norm()).epsilon(1e-10));
      const Vector3 centre = lower_centre + 0.5 * x - 0.5 * (upper_radius - 3.0) * contact_point.normal;
      CHECK((contact_point.centre - centre).norm() < round_off);
    }
  }
}

TEST_CASE("sphere_pair: requires a positive effective radius, and convex surfaces unless signed (rule 3)") {
  const Asperity ball = inclined_asperity(0.0, 2.0, Side::upper);
  CHECK(stiction::sphere_pair(ball, inclined_asperity(0.0, 3.0, Side::lower), 0.0, Curvature::convex).has_value());
  CHECK_FALSE(
      stiction::sphere_pair(ball, inclined_asperity(0.0, -3.0, Side::lower), 0.0, Curvature::convex).has_value());
  CHECK(stiction::sphere_pair(ball, inclined_asperity(0.0, -3.0, Side::lower), 0.0, Curvature::signed_).has_value());
  CHECK_FALSE(
      stiction::sphere_pair(ball, inclined_asperity(0.0, -1.0, Side::lower), 0.0, Curvature::signed_).has_value());
  CHECK_FALSE(stiction::sphere_on_flat(inclined_asperity(0.0, -1.0, Side::lower), Side::lower, ball, 0.0).has_value());
}

TEST_CASE("SphereOnFlat: the overlap is the approach along the normal of the flat") {
  const double tilt = 0.3;
  const Asperity sphere = inclined_asperity(tilt, 2.0, Side::lower);
  const auto on = stiction::sphere_on_flat(sphere, Side::lower, inclined_asperity(tilt, 0.0, Side::upper), 0.01);
  REQUIRE(on.has_value());
  const ContactPoint contact_point = on->contact_at(0.05);
  CHECK(contact_point.overlap == doctest::Approx((0.05 - 0.01) * std::cos(tilt)).epsilon(round_off));
  CHECK(contact_point.normal.isApprox(sphere.normal, round_off));
  CHECK(stiction::radii(*on).major == 2.0);
}

TEST_CASE("classify: a cell is closed on its left and open on its right (rules 1, 2 and 4, Eq. 5)") {
  const Vector3 up(0.0, 0.0, 1.0);
  const auto at = [&](double x, double overlap, const Vector3& normal) {
    return stiction::classify({normal, Vector3(x, 0.0, 0.0), overlap}, 0.5);
  };
  CHECK(at(-0.5, 0.1, up) == ContactClass::contact);
  CHECK(at(0.5, 0.1, up) == ContactClass::no_contact);
  CHECK(at(0.0, 0.0, up) == ContactClass::no_contact);
  CHECK(at(0.0, 0.1, -up) == ContactClass::crossed);
  CHECK(at(0.0, std::nan(""), up) == ContactClass::no_contact);
}

TEST_CASE("Radii::mean: is exact for a sphere, and the geometric mean for an ellipse") {
  for (const double radius : {0.1, 1.0 / 3.0, 1e-200, 1e200}) {
    CHECK(stiction::Radii{radius, radius}.mean() == radius);
  }
  CHECK(stiction::Radii{8.0, 2.0}.mean() == doctest::Approx(4.0).epsilon(round_off));
}
