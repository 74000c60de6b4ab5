#include "stiction/contact_statistics.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <stdexcept>
#include <vector>

using stiction::ContactTable;
using stiction::ContactView;
using stiction::Grid;

namespace {

constexpr double round_off = 1e-14;
const std::vector<double> probabilities = {0.25, 0.5, 0.9};

}  // namespace

TEST_CASE("contact_statistics: returns load fractions and quantiles of three contacts") {
  const std::vector<double> force = {1, 2, 5};
  const std::vector<double> area = {3, 1, 2};
  const std::vector<double> cells = {1, 4, 9};
  const std::array<bool, 3> at_edge = {true, false, false};
  const std::vector<double> pressure = {2, 1};
  const std::vector<double> weight = {1, 3};
  const auto statistics =
      stiction::contact_statistics({force, area, cells, at_edge, pressure, weight}, probabilities, 4);
  CHECK(statistics.fraction_on_largest == 0.625);
  CHECK(statistics.fraction_at_edge == 0.125);
  CHECK(statistics.fraction_on_small == 0.375);
  CHECK(statistics.area_quantiles[0] == 1.5);
  CHECK(statistics.area_quantiles[1] == 2.0);
  CHECK(statistics.area_quantiles[2] == doctest::Approx(2.8).epsilon(round_off));
  // The two pressures are quantiles at the probabilities 3/8 and 7/8, at which their own weights are counted half.
  CHECK(statistics.pressure_quantiles[0] == 1.0);
  CHECK(statistics.pressure_quantiles[1] == doctest::Approx(1.25).epsilon(round_off));
  CHECK(statistics.pressure_quantiles[2] == 2.0);
}

TEST_CASE("contact_statistics: rejects arrays of different lengths, empty tables and unordered probabilities") {
  const std::vector<double> two = {1, 2};
  const std::vector<double> one = {1};
  const std::array<bool, 2> at_edge = {true, false};
  const auto compute = [](const ContactTable& table, const std::vector<double>& of = probabilities) {
    return stiction::contact_statistics(table, of, 4);
  };
  CHECK_NOTHROW(compute({two, two, two, at_edge, one, one}));
  CHECK_THROWS_AS(compute({two, one, two, at_edge, one, one}), std::invalid_argument);
  CHECK_THROWS_AS(compute({two, two, two, at_edge, one, two}), std::invalid_argument);
  CHECK_THROWS_AS(compute({two, two, two, at_edge, {}, {}}), std::invalid_argument);
  CHECK_THROWS_AS(compute({}), std::invalid_argument);
  CHECK_THROWS_AS(compute({two, two, two, at_edge, one, one}, {0.5, 0.25}), std::invalid_argument);
}

TEST_CASE("patch_statistics: counts patches at map edges, and patch areas in cells of the grid") {
  const std::vector<std::int64_t> points = {0, 5, 6};
  const std::vector<double> pressure = {1, 2, 1};
  const std::vector<double> fraction = {0.5, 1, 1};
  const std::vector<std::int32_t> patch = {1, 2, 2};
  const ContactView contact{points, pressure, fraction, patch};
  const Grid line{1, 9, 1.0, 0.5, true, false};
  const Grid area{3, 4, 0.5, 0.5, false, false};
  const auto of_line = stiction::patch_statistics(contact, line, probabilities, 1);
  CHECK(of_line.fraction_at_edge == 0.25);
  CHECK(of_line.fraction_on_small == 0.25);
  CHECK(of_line.fraction_on_largest == 0.75);
  CHECK(of_line.area_quantiles[1] == doctest::Approx(0.625).epsilon(round_off));
  const auto of_area = stiction::patch_statistics(contact, area, probabilities, 4);
  CHECK(of_area.fraction_at_edge == 0.25);
  CHECK(of_area.fraction_on_small == 1.0);
  CHECK(of_area.area_quantiles[1] == doctest::Approx(0.3125).epsilon(round_off));
  const std::vector<std::int64_t> beyond = {0, 5, 12};
  CHECK_THROWS_AS(stiction::patch_statistics({beyond, pressure, fraction, patch}, area, probabilities, 4),
                  std::invalid_argument);
}

TEST_CASE("load_fraction_on_marked_points: sums the pressures at marked points") {
  const std::vector<std::int64_t> points = {0, 2, 3};
  const std::vector<double> pressure = {1, 2, 1};
  const std::vector<std::int32_t> patch = {1, 2, 2};
  const ContactView contact{points, pressure, pressure, patch};
  const std::array<bool, 4> marks = {false, true, true, false};
  CHECK(stiction::load_fraction_on_marked_points(contact, marks) == 0.5);
  CHECK_THROWS_AS(stiction::load_fraction_on_marked_points(contact, {marks.data(), 3}), std::invalid_argument);
}
