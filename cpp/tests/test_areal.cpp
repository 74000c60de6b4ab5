#include "stiction/areal.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

using stiction::ArealCandidates;
using stiction::candidates;
using stiction::Curvature;
using stiction::Index;
using stiction::Law;
using stiction::Matrix;
using stiction::Meeting;
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

TEST_CASE("relative curvatures are those in the tangent plane") {
  // On a slope p along x a curvature along x is over q³, one across it over q.
  constexpr double tolerance = 1e-14;
  const double p = 0.75;
  const double q = 1.25;
  const Meeting across = stiction::meeting({p, 0.0}, 2.0, 0.0, 0.1);
  CHECK(across.radii.minor == doctest::Approx(q * q * q / 2.0).epsilon(tolerance));
  CHECK(across.radii.major == doctest::Approx(q / 0.1).epsilon(tolerance));
  CHECK((across.normal - stiction::Vector3(-p / q, 0.0, 1.0 / q)).norm() < tolerance);
  CHECK(std::abs(across.along.y()) == doctest::Approx(1.0).epsilon(tolerance));
  const Meeting along = stiction::meeting({p, 0.0}, 0.1, 0.0, 2.0);
  CHECK(along.radii.major == doctest::Approx(q * q * q / 0.1).epsilon(tolerance));
  CHECK(std::abs(along.along.x()) == doctest::Approx(1.0 / q).epsilon(tolerance));
  CHECK(std::abs(along.along.z()) == doctest::Approx(p / q).epsilon(tolerance));
  const Meeting round = stiction::meeting({0.0, 0.0}, 0.5, 0.0, 0.5);
  CHECK(round.radii.major == 2.0);
  CHECK(round.radii.minor == 2.0);
}

TEST_CASE("a paraboloid on a flat is one elliptic contact, in every direction and by both rules") {
  constexpr double tolerance = 1e-7;  // the edges, where the spline has no curvature, are 15 points away: 0.268^15
  const Matrix upper = paraboloid(31, 41, 3.0, 1.0);
  const Matrix lower = Matrix::Zero(31, 41);
  const ArealCandidates found = candidates({upper, lower, {spacing, spacing}}, 0.01, Curvature::signed_);
  REQUIRE(found.all.size() == 1);
  const auto& one = found.all.front();
  CHECK(one.position.x() == doctest::Approx(20.3 * spacing).epsilon(tolerance));
  CHECK(one.position.y() == doctest::Approx(15.6 * spacing).epsilon(tolerance));
  CHECK(one.radii.major == doctest::Approx(3.0).epsilon(tolerance));
  CHECK(one.radii.minor == doctest::Approx(1.0).epsilon(tolerance));
  CHECK(found.grid_minima.size() == 1);
  CHECK(found.unanswered.empty());
  const Law law = stiction::HertzSphere{10.0};
  const std::vector<double> approaches{0.001, 0.01};
  const std::vector<Vector2> directions{{1.0, 0.0}, {0.6, 0.8}};
  for (const Sliding sliding : {Sliding::opposing, Sliding::all}) {
    const auto sums = stiction::press(found, approaches, law, directions, sliding);
    REQUIRE(sums.size() == 4);
    const double force = 4.0 / 3.0 * 10.0 * std::sqrt(one.ellipse.stiff) * std::pow(one.overlap(0.01), 1.5);
    CHECK(sums[1].normal_elastic == doctest::Approx(force).epsilon(1e-14));
    CHECK(sums[3].tangential_frictional == doctest::Approx(sliding == Sliding::all ? force : 0.0).epsilon(1e-14));
  }
  CHECK(stiction::contacts(found, 0.01, law, directions[1]).size() == 1);
}

TEST_CASE("what cannot be pressed is refused") {
  const Matrix upper = paraboloid(31, 41, 3.0, 1.0);
  const Matrix lower = Matrix::Zero(31, 41);
  const Matrix other = Matrix::Zero(31, 40);
  Matrix holey = upper;
  holey(3, 7) = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [](const Matrix& above, const Matrix& below, double deepest) {
    CHECK_THROWS_AS(candidates({above, below, {spacing, spacing}}, deepest, Curvature::signed_), std::invalid_argument);
  };
  refused(upper, other, 0.1);
  refused(upper, upper, 0.1);
  refused(holey, lower, 0.1);
  refused(upper, lower, -0.1);
  const ArealCandidates found = candidates({upper, lower, {spacing, spacing}}, 0.01, Curvature::signed_);
  const std::vector<double> approaches{0.01};
  const std::vector<Vector2> directions{{1.0, 0.0}};
  const std::vector<Vector2> none{{1.0, 1.0}};
  CHECK_THROWS_AS(press(found, approaches, stiction::HertzCylinder{10.0, 1.0}, directions, Sliding::all),
                  std::invalid_argument);
  CHECK_THROWS_AS(press(found, approaches, stiction::HertzSphere{10.0}, none, Sliding::all), std::invalid_argument);
  const std::vector<double> deeper{0.02};
  CHECK_THROWS_AS(press(found, deeper, stiction::HertzSphere{10.0}, directions, Sliding::all), std::invalid_argument);
}
