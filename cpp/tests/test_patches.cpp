#include "stiction/patches.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <vector>

using stiction::Grid;

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double round_off = 1e-14;

}  // namespace

TEST_CASE("patches_of: connects points across corners and across periodic edges") {
  const std::vector<double> pressure = {1, 0, 0, 0, 1,  //
                                        0, 1, 0, 0, 0,  //
                                        0, 0, 0, 0, 0,  //
                                        0, 0, 2, 0, 1};
  Grid grid{4, 5, 1.0, 1.0, false, false};
  CHECK(stiction::patches_of(pressure, grid, infinite).patch == std::vector<std::int32_t>{1, 2, 1, 3, 4});
  grid.periodic = true;
  const auto around = stiction::patches_of(pressure, grid, infinite);
  CHECK(around.patch == std::vector<std::int32_t>{1, 1, 1, 2, 1});
  CHECK(around.count == 2);
  CHECK(around.points == std::vector<std::int64_t>{0, 4, 6, 17, 19});
}

TEST_CASE(
    "patches_of: open sides reduce the contact fraction, grid edges do not, and the hardness limits the fraction") {
  const Grid line{1, 4, 1.0, 1.0, true, false};
  const auto patches = stiction::patches_of(std::vector<double>{1, 1, 0, 1}, line, infinite);
  CHECK(patches.contact_fraction[0] == 1.0);
  CHECK(patches.contact_fraction[1] == doctest::Approx(0.81).epsilon(round_off));
  CHECK(patches.contact_fraction[2] == doctest::Approx(0.81).epsilon(round_off));
  CHECK(stiction::patches_of(std::vector<double>{1, 1, 0, 1}, line, 1.0).contact_fraction[1] == 1.0);
  CHECK_THROWS_AS(stiction::patches_of(std::vector<double>{1}, line, 1.0), std::invalid_argument);
}

TEST_CASE("patch_sums: a patch on a slope opposes the upward motion, with friction along the slope") {
  const std::vector<std::int64_t> points = {1, 2};
  const std::vector<double> pressure = {1, 0.5};
  const std::vector<double> fraction = {0.5, 1.5};
  const std::vector<std::int32_t> patch = {1, 1};
  const std::vector<double> rise = {0, 0.75, 0.75};
  const std::vector<std::array<double, 2>> ways = {{1, 0}, {0, 1}};
  const std::vector<stiction::ContactView> contacts = {{points, pressure, fraction, patch}};
  const auto sums = stiction::patch_sums(contacts, {}, rise, 2.0, ways);
  CHECK(sums.area[0] == 5.0);  // the contact area is 1.25 times the projected area
  CHECK(sums.leaning == std::vector<double>{2.25, 0});
  CHECK(sums.upward == std::vector<double>{-2.25, 0});
  CHECK(sums.forward == std::vector<double>{3, 3.75});
  CHECK(sums.forward_area == std::vector<double>{4, 5});
  CHECK(sums.steepness == std::vector<double>{0.75});
}

TEST_CASE("patch_sums: patches of several contacts follow each other, with the slope of each contact") {
  const std::vector<std::int64_t> first = {0, 2};
  const std::vector<std::int64_t> second = {1};
  const std::vector<double> ones = {1, 1};
  const std::vector<std::int32_t> patch = {1, 2};
  const std::vector<double> rise = {0, 0.75, 0};
  const std::vector<std::array<double, 2>> ways = {{1, 0}};
  const std::vector<stiction::ContactView> contacts = {{first, ones, ones, patch},
                                                       {second, {ones.data(), 1}, {ones.data(), 1}, {patch.data(), 1}}};
  const auto sums = stiction::patch_sums(contacts, {}, rise, 1.0, ways);
  CHECK(sums.first_patch == std::vector<std::int64_t>{0, 2});
  CHECK(sums.leaning == std::vector<double>{0, 0, 0.75});
  CHECK(sums.steepness == std::vector<double>{0, 0.75});
}

TEST_CASE("patch_sums: rejects arrays of different lengths, points beyond the grid and contacts without points") {
  const std::vector<std::int64_t> points = {0, 1};
  const std::vector<std::int64_t> beyond = {0, 2};
  const std::vector<double> ones = {1, 1};
  const std::vector<double> one = {1};
  const std::vector<std::int32_t> patch = {1, 1};
  const std::vector<std::int32_t> unnumbered = {0, 1};
  const auto sum = [&](const stiction::ContactView& contact, stiction::Values slope_y = {}) {
    return stiction::patch_sums(std::vector{contact}, slope_y, ones, 1.0, {});
  };
  CHECK_NOTHROW(sum({points, ones, ones, patch}));
  CHECK_THROWS_AS(sum({points, ones, ones, unnumbered}), std::invalid_argument);
  CHECK_THROWS_AS(sum({points, one, ones, patch}), std::invalid_argument);
  CHECK_THROWS_AS(sum({beyond, ones, ones, patch}), std::invalid_argument);
  CHECK_THROWS_AS(sum({}), std::invalid_argument);
  CHECK_THROWS_AS(sum({points, ones, ones, patch}, one), std::invalid_argument);
}
