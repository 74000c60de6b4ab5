#include "stiction/law.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <variant>

using stiction::ForceArea;
using stiction::HertzCylinder;
using stiction::HertzSphere;
using stiction::JacksonGreen;

namespace {
constexpr double round_off = 1e-14;
constexpr stiction::Radii unit{1.0, 1.0};
}  // namespace

TEST_CASE("HertzSphere: force and area match the formulas for the contact radius") {
  // For the contact radius a = sqrt(R overlap) = 2 µm, F = 4 E* a³ / (3 R) and A = π a².
  const auto [force, area] = HertzSphere{3.0}(0.5, {8.0, 8.0});
  CHECK(force == doctest::Approx(4.0).epsilon(round_off));
  CHECK(area == doctest::Approx(4.0 * std::numbers::pi).epsilon(round_off));
}

TEST_CASE("HertzCylinder: force and area match the formulas for the half-width") {
  // For the half-width a = 2 µm, Johnson (1985), section 4.2(c), gives a² = 4 F R / (π E* w), and A = 2 a w.
  const auto [force, area] = HertzCylinder{3.0, 5.0}(0.5, {8.0, 8.0});
  CHECK(4.0 * force * 8.0 / (std::numbers::pi * 3.0 * 5.0) == doctest::Approx(4.0).epsilon(round_off));
  CHECK(area == doctest::Approx(20.0).epsilon(round_off));
}

TEST_CASE("JacksonGreen: equals Hertz below yield and tends to the hardness far above it") {
  const JacksonGreen law{100.0, 0.2, 0.3};
  const double constraint = 1.295 * std::exp(0.736 * 0.3);
  const double critical = std::pow(0.5 * std::numbers::pi * constraint * 0.002, 2);
  const HertzSphere hertz{100.0};
  for (const double ratio : {0.01, 1.0, 1.89}) {
    CHECK(law(ratio * critical, unit).force == hertz(ratio * critical, unit).force);
    CHECK(law(ratio * critical, unit).area == hertz(ratio * critical, unit).area);
  }
  // At 1.9 times the critical interference, the fitted load is within 1 % of Hertz theory, and the area is continuous.
  const ForceArea below = law(1.9 * critical * (1.0 - 1e-12), unit);
  const ForceArea above = law(1.9 * critical * (1.0 + 1e-12), unit);
  CHECK(std::abs(above.force / below.force - 1.0) < 0.01);
  CHECK(above.area == doctest::Approx(below.area).epsilon(1e-11));
  // The mean pressure of small plastic contacts tends to the hardness 2.84 S_y. The fit is within 5 % of the hardness.
  const ForceArea plastic = law(1000.0 * critical, unit);
  const double contact_radius = std::sqrt(plastic.area / std::numbers::pi);
  const double hardness = 2.84 * 0.2 * (1.0 - std::exp(-0.82 * std::pow(contact_radius, -0.7)));
  CHECK(plastic.force / plastic.area == doctest::Approx(hardness).epsilon(0.05));
  double force = 0.0;
  double area = 0.0;
  for (double ratio = 0.5; ratio < 2000.0; ratio *= 1.5) {
    const ForceArea carried = law(ratio * critical, unit);
    CHECK(carried.force > force);
    CHECK(carried.area > area);
    CHECK(carried.force < 1.01 * hertz(ratio * critical, unit).force);
    force = carried.force;
    area = carried.area;
  }
}

TEST_CASE("check: parameters out of range throw") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_NOTHROW(stiction::check(JacksonGreen{10.0, 0.9, 0.0}));
  CHECK_THROWS_AS(stiction::check(HertzSphere{0.0}), std::invalid_argument);
  CHECK_THROWS_AS(stiction::check(HertzSphere{nan}), std::invalid_argument);
  CHECK_THROWS_AS(stiction::check(HertzCylinder{10.0, 0.0}), std::invalid_argument);
  CHECK_THROWS_AS(stiction::check(HertzCylinder{-1.0, 1.0}), std::invalid_argument);
  CHECK_THROWS_AS(stiction::check(JacksonGreen{10.0, 1.0, 0.3}), std::invalid_argument);
  CHECK_THROWS_AS(stiction::check(JacksonGreen{10.0, nan, 0.3}), std::invalid_argument);
  CHECK_THROWS_AS(stiction::check(JacksonGreen{10.0, 0.1, 0.51}), std::invalid_argument);
}

TEST_CASE("law: requires exactly the parameters of the named law") {
  CHECK(std::holds_alternative<HertzCylinder>(
      stiction::law("hertz-cylinder", {{"effective_modulus", 3.0}, {"width", 5.0}})));
  CHECK_THROWS_WITH(stiction::law("hertz", {}), "unknown law hertz");
  CHECK_THROWS_WITH(stiction::law("hertz-cylinder", {{"effective_modulus", 3.0}}),
                    "law hertz-cylinder requires the parameter width");
  CHECK_THROWS_WITH(stiction::law("hertz-sphere", {{"effective_modulus", 3.0}, {"width", 5.0}}),
                    "law hertz-sphere has no parameter width");
  CHECK_THROWS_WITH(stiction::law("hertz-sphere", {{"effective_modulus", 0.0}}),
                    "effective_modulus must be above 0 and finite, got 0 GPa");
}

TEST_CASE("semi_axes: are consistent with the contact area of an ellipse or a strip") {
  const stiction::Radii radii{2.0, 2.0};
  for (const stiction::Law& law : {stiction::Law(HertzSphere{10.0}), stiction::Law(JacksonGreen{10.0, 0.1, 0.3})}) {
    const auto [area, axes] = std::visit(
        [&](const auto& any_law) { return std::pair(any_law(0.1, radii).area, any_law.semi_axes(0.1, radii)); }, law);
    CHECK(std::numbers::pi * axes.prod() == doctest::Approx(area).epsilon(round_off));
  }
  const HertzCylinder strip{10.0, 3.0};
  CHECK(4.0 * strip.semi_axes(0.1, radii).prod() == doctest::Approx(strip(0.1, radii).area).epsilon(round_off));
}
