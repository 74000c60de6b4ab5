#include "stiction/areal.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

using stiction::ArealCandidates;
using stiction::candidates;
using stiction::ContactGeometry;
using stiction::Curvature;
using stiction::Index;
using stiction::Law;
using stiction::Matrix;
using stiction::Sliding;
using stiction::Vector2;

namespace {

constexpr double spacing = 0.05;

Matrix paraboloid(Index rows, Index columns, double along_x, double along_y) {
  Matrix heights(rows, columns);
  for (Index j = 0; j < rows; ++j) {
    for (Index i = 0; i < columns; ++i) {
      const double x = (static_cast<double>(i) - 20.3) * spacing;
      const double y = (static_cast<double>(j) - 15.6) * spacing;
      heights(j, i) = 0.5 * (x * x / along_x + y * y / along_y);
    }
  }
  return heights;
}

}  // namespace

TEST_CASE("contact_geometry: relative curvatures are measured in the tangent plane") {
  // On a slope p along x, with q = sqrt(1 + p²), curvatures along x are divided by q³, and curvatures along y by q.
  constexpr double tolerance = 1e-14;
  const double p = 0.75;
  const double q = 1.25;
  const ContactGeometry across = stiction::contact_geometry({p, 0.0}, 2.0, 0.0, 0.1);
  CHECK(across.radii.minor == doctest::Approx(q * q * q / 2.0).epsilon(tolerance));
  CHECK(across.radii.major == doctest::Approx(q / 0.1).epsilon(tolerance));
  CHECK((across.normal - stiction::Vector3(-p / q, 0.0, 1.0 / q)).norm() < tolerance);
  CHECK(std::abs(across.along.y()) == doctest::Approx(1.0).epsilon(tolerance));
  const ContactGeometry along = stiction::contact_geometry({p, 0.0}, 0.1, 0.0, 2.0);
  CHECK(along.radii.major == doctest::Approx(q * q * q / 0.1).epsilon(tolerance));
  CHECK(std::abs(along.along.x()) == doctest::Approx(1.0 / q).epsilon(tolerance));
  CHECK(std::abs(along.along.z()) == doctest::Approx(p / q).epsilon(tolerance));
  const ContactGeometry round = stiction::contact_geometry({0.0, 0.0}, 0.5, 0.0, 0.5);
  CHECK(round.radii.major == 2.0);
  CHECK(round.radii.minor == 2.0);
}

TEST_CASE("areal press: a paraboloid on a flat has one elliptic contact for all directions and sliding rules") {
  // The spline has zero curvature at the map's edges. The resulting error 15 points from an edge is 0.268^15 = 3e-9.
  constexpr double tolerance = 1e-7;
  const Matrix upper = paraboloid(31, 41, 3.0, 1.0);
  const Matrix lower = Matrix::Zero(31, 41);
  const ArealCandidates all_candidates = candidates({upper, lower, {spacing, spacing}}, 0.01, Curvature::signed_);
  REQUIRE(all_candidates.all.size() == 1);
  const auto& candidate = all_candidates.all.front();
  CHECK(candidate.position.x() == doctest::Approx(20.3 * spacing).epsilon(tolerance));
  CHECK(candidate.position.y() == doctest::Approx(15.6 * spacing).epsilon(tolerance));
  CHECK(candidate.radii.major == doctest::Approx(3.0).epsilon(tolerance));
  CHECK(candidate.radii.minor == doctest::Approx(1.0).epsilon(tolerance));
  CHECK(all_candidates.grid_minima.size() == 1);
  CHECK(all_candidates.unanswered.empty());
  const Law law = stiction::HertzSphere{10.0};
  const std::vector<double> approaches{0.001, 0.01};
  const std::vector<Vector2> directions{{1.0, 0.0}, {0.6, 0.8}};
  for (const Sliding sliding : {Sliding::opposing, Sliding::all}) {
    const auto sums = stiction::press(all_candidates, approaches, law, directions, sliding);
    REQUIRE(sums.size() == 4);
    const double force =
        4.0 / 3.0 * 10.0 * std::sqrt(candidate.ellipse.force_radius) * std::pow(candidate.overlap(0.01), 1.5);
    CHECK(sums[1].normal_elastic == doctest::Approx(force).epsilon(1e-14));
    CHECK(sums[3].tangential_frictional == doctest::Approx(sliding == Sliding::all ? force : 0.0).epsilon(1e-14));
  }
  CHECK(stiction::contacts(all_candidates, 0.01, law, directions[1]).size() == 1);
}

TEST_CASE("tangent: is a unit tangent and matches the sliding factors, also at walls along the motion") {
  // The angle between -s and the horizontal part of n is `turn`. If `turn` and n_z are small, (s·n) n - s is inexact.
  for (const double turn : {0.0, 1e-9, 1e-6, 1e-3, 0.5}) {
    for (const double up : {1e-12, 1e-3, 0.5}) {
      const double level = std::sqrt(1.0 - up * up);
      const stiction::Vector3 normal(-level * std::cos(turn), level * std::sin(turn), up);
      const Vector2 direction(1.0, 0.0);
      const stiction::Vector3 t = stiction::tangent(normal, direction);
      const stiction::SlidingFactors by = stiction::sliding_factors(normal, direction);
      CHECK(std::abs(t.norm() - 1.0) < 1e-15);
      CHECK(std::abs(t.dot(normal)) < 1e-15);
      CHECK(-t.x() == doctest::Approx(by.drag).epsilon(1e-15));
      CHECK(t.z() == doctest::Approx(by.lift).epsilon(1e-15));
    }
  }
}

TEST_CASE("areal press: an ellipse much larger than the map contributes the area of the map") {
  const Matrix upper = paraboloid(31, 41, 1e4, 1e4);
  const Matrix lower = Matrix::Zero(31, 41);
  const ArealCandidates all_candidates = candidates({upper, lower, {spacing, spacing}}, 1e9, Curvature::signed_);
  REQUIRE(all_candidates.all.size() == 1);
  for (const double approach : {1e3, 1e6, 1e9}) {
    const auto table = stiction::contacts(all_candidates, approach, stiction::HertzSphere{10.0}, {1.0, 0.0});
    REQUIRE(table.size() == 1);
    // The ellipse covers the map. The force is at most the map area times the peak pressure 2 E* (d / R)^(1/2) / π.
    const double area = 40.0 * 30.0 * spacing * spacing;
    CHECK(table[0].area == doctest::Approx(area).epsilon(1e-12));
    const double radius = std::sqrt(table[0].radii.major * table[0].radii.minor);
    const double max_force = 20.0 / 3.141592653589793 * std::sqrt(table[0].overlap / radius) * area;
    CHECK(table[0].force <= max_force * (1.0 + 1e-12));
    CHECK(table[0].force == doctest::Approx(max_force).epsilon(2.0 / (radius * table[0].overlap)));
  }
}

TEST_CASE("areal candidates and press: invalid arguments throw") {
  const Matrix upper = paraboloid(31, 41, 3.0, 1.0);
  const Matrix lower = Matrix::Zero(31, 41);
  const Matrix other_shape = Matrix::Zero(31, 40);
  Matrix holey = upper;
  holey(3, 7) = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [](const Matrix& above, const Matrix& below, double deepest) {
    CHECK_THROWS_AS(candidates({above, below, {spacing, spacing}}, deepest, Curvature::signed_), std::invalid_argument);
  };
  refused(upper, other_shape, 0.1);
  refused(upper, upper, 0.1);
  refused(holey, lower, 0.1);
  refused(upper, lower, -0.1);
  const ArealCandidates all_candidates = candidates({upper, lower, {spacing, spacing}}, 0.01, Curvature::signed_);
  const std::vector<double> approaches{0.01};
  const std::vector<Vector2> directions{{1.0, 0.0}};
  const std::vector<Vector2> none{{1.0, 1.0}};
  CHECK_THROWS_AS(press(all_candidates, approaches, stiction::HertzCylinder{10.0, 1.0}, directions, Sliding::all),
                  std::invalid_argument);
  CHECK_THROWS_AS(press(all_candidates, approaches, stiction::HertzSphere{10.0}, none, Sliding::all),
                  std::invalid_argument);
  const std::vector<double> deeper{0.02};
  CHECK_THROWS_AS(press(all_candidates, deeper, stiction::HertzSphere{10.0}, directions, Sliding::all),
                  std::invalid_argument);
}
