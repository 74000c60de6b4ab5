#include "stiction/ellipse.hpp"

#include <doctest/doctest.h>
#include <gsl/gsl_sf_ellint.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

using std::numbers::pi;
using stiction::Ellipse;
using stiction::hertz_ellipse;

TEST_CASE("hertz_ellipse: matches Johnson's equations with GSL's elliptic integrals") {
  for (const double k : {0.99, 0.9, 0.5, 0.1, 0.02, 1e-3}) {
    const double e2 = 1.0 - k * k;
    // Near the axis ratio k = 1, K - E and E - k² K lose digits, because their terms nearly cancel.
    // Near the axis ratio k = 0, the round-off of e limits the accuracy of k² = 1 - e².
    const double tolerance = 1e-14 / e2 + 1e-15 / (k * k);
    const double first = gsl_sf_ellint_Kcomp(std::sqrt(e2), GSL_PREC_DOUBLE);
    const double second = gsl_sf_ellint_Ecomp(std::sqrt(e2), GSL_PREC_DOUBLE);
    const double ratio = k * k * (first - second) / (second - k * k * first);
    const double longer = 3.0;
    const Ellipse ellipse = hertz_ellipse(longer, longer * ratio);
    CHECK(std::sqrt(ellipse.minor / ellipse.major) == doctest::Approx(k).epsilon(tolerance));
    const double a2 = 2.0 * longer * (first - second) / (e2 * first);
    CHECK(ellipse.major == doctest::Approx(a2).epsilon(tolerance));
    CHECK(4.0 / 3.0 * std::sqrt(ellipse.force_radius) ==
          doctest::Approx(2.0 / 3.0 * pi * std::sqrt(a2) / first).epsilon(tolerance));
  }
}

TEST_CASE("hertz_ellipse: tends to the sphere for equal and nearly equal radii") {
  const Ellipse sphere = hertz_ellipse(2.5, 2.5);
  CHECK(sphere.major == doctest::Approx(2.5).epsilon(1e-15));
  CHECK(sphere.minor == doctest::Approx(2.5).epsilon(1e-15));
  CHECK(sphere.force_radius == doctest::Approx(2.5).epsilon(1e-15));
  // For nearly equal radii of curvature, the axis ratio is b/a = (shorter radius / longer radius)^(2/3) to first order.
  // To second order, contact area and force are those of a sphere whose radius is the geometric mean of both radii.
  for (const double excess : {1e-3, 1e-6, 1e-12}) {
    const Ellipse near = hertz_ellipse(1.0 + excess, 1.0);
    CHECK(std::abs(std::sqrt(near.minor / near.major) - (1.0 - 2.0 / 3.0 * excess)) < excess * excess + 1e-15);
    CHECK(std::abs(near.major * near.minor / (1.0 + excess) - 1.0) < excess * excess + 1e-15);
    CHECK(std::abs(near.force_radius / std::sqrt(1.0 + excess) - 1.0) < excess * excess + 1e-15);
  }
}

TEST_CASE("hertz_ellipse: matches the asymptotic formula for very long ellipses") {
  // For axis ratios k -> 0: K = ln(4/k), shorter/longer = k² (K - 1), a² = 2 d longer (1 - 1/K), b² = 2 d shorter / K.
  for (const double k : {1e-7, 1e-20, 1e-100}) {
    const double first = std::log(4.0 / k);
    const double shorter = 0.7;
    const Ellipse ellipse = hertz_ellipse(shorter / (k * k * (first - 1.0)), shorter);
    CHECK(ellipse.minor == doctest::Approx(2.0 * shorter / first).epsilon(1e-12));
    CHECK(std::sqrt(ellipse.minor / ellipse.major) == doctest::Approx(k).epsilon(1e-12));
  }
}

TEST_CASE("hertz_ellipse: invalid radii throw") {
  CHECK_THROWS_AS(hertz_ellipse(1.0, 0.0), std::invalid_argument);
  CHECK_THROWS_AS(hertz_ellipse(1.0, 2.0), std::invalid_argument);
  CHECK_THROWS_AS(hertz_ellipse(std::numeric_limits<double>::infinity(), 2.0), std::invalid_argument);
  CHECK_THROWS_AS(hertz_ellipse(std::numeric_limits<double>::quiet_NaN(), 2.0), std::invalid_argument);
}
