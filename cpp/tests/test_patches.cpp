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
  const std::vector<double> force = {2, 1};
  const std::vector<double> area = {1, 3};
  const std::vector<double> rise = {0.75, 0.75};
  const std::vector<std::array<double, 2>> ways = {{1, 0}, {0, 1}};
  const std::vector<std::int32_t> patch = {1, 1};
  const auto sums = stiction::patch_sums(force, area, {}, rise, patch, ways);
  CHECK(sums.area[0] == 5.0);  // the contact area is 1.25 times the projected area
  CHECK(sums.leaning == std::vector<double>{2.25, 0});
  CHECK(sums.upward == std::vector<double>{-2.25, 0});
  CHECK(sums.forward == std::vector<double>{3, 3.75});
  CHECK(sums.forward_area == std::vector<double>{4, 5});
  CHECK(sums.steepness == 0.75);
  CHECK_THROWS_AS(stiction::patch_sums(force, area, {}, rise, std::vector<std::int32_t>{0, 1}, ways),
                  std::invalid_argument);
  CHECK_THROWS_AS(stiction::patch_sums(force, area, rise, std::vector<double>{1}, patch, ways), std::invalid_argument);
}
