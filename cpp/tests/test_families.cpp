#include "stiction/families.hpp"
#include "stiction/harmonics.hpp"

#include <doctest/doctest.h>

#include <array>
#include <numbers>
#include <random>
#include <stdexcept>
#include <vector>

namespace {

using stiction::Index;
using stiction::Matrix;

constexpr Index points = 3000;  // neither whole blocks nor whole pieces
constexpr Index members = 3;
constexpr double spacing = 0.002;
const std::vector<double> approaches{0.002, 0.01, 0.03};

struct Made {
  Matrix heights;
  std::vector<stiction::Level> levels;
};

Made family(unsigned seed) {
  std::mt19937_64 random(seed);
  Matrix phases(8, 12);
  for (double& phase : phases.reshaped()) {
    phase = 2.0 * std::numbers::pi * static_cast<double>(random() >> 11) * 0x1p-53;
  }
  Matrix weights(members, phases.cols());
  for (Index row = 0; row < members; ++row) {
    const auto of_row = stiction::frequency_weights(0.8 + 0.3 * static_cast<double>(row), phases.cols(), 1.5, 1.0);
    weights.row(row) = Eigen::Map<const Eigen::RowVectorXd>(of_row.data(), phases.cols());
  }
  Made made{Matrix(members, points), {}};
  made.levels = stiction::harmonic_profiles(phases, weights, {spacing, points}, made.heights);
  return made;
}

stiction::Values row_of(const Matrix& heights, Index row) {
  return {heights.row(row).data(), static_cast<std::size_t>(heights.cols())};
}

std::vector<double> numbers(const stiction::Sums& sums) {
  std::vector<double> all;
  for (const stiction::Quantity& quantity : stiction::quantities) {
    std::visit([&](auto member) { all.push_back(static_cast<double>(sums.*member)); }, quantity.member);
  }
  return all;
}

std::vector<stiction::ContactModel> models() {
  std::vector<stiction::ContactModel> all(2, stiction::ContactModel{stiction::HertzSphere{10.0}});
  all[1].detection = stiction::Detection::gap_minimum;
  all[1].sliding = stiction::Sliding::all;
  return all;
}

}  // namespace

TEST_CASE("levels of generated profiles are those of the whole rows, to the bit") {
  const Made made = family(1);
  for (Index row = 0; row < members; ++row) {
    stiction::Levelling whole;
    whole.add(row_of(made.heights, row));
    const stiction::Level& level = made.levels[static_cast<std::size_t>(row)];
    CHECK(level.mean == whole.level().mean);
    CHECK(level.lowest == made.heights.row(row).minCoeff());
    CHECK(level.highest == made.heights.row(row).maxCoeff());
  }
}

TEST_CASE("families give what each pair gives, scaled and pressed alone, to the bit") {
  const std::vector<double> amplitudes{0.05, 0.1};
  for (const auto measure : {stiction::AmplitudeMeasure::height, stiction::AmplitudeMeasure::rq}) {
    Made upper = family(1);
    Made lower = family(2);
    const Made upper_before = upper;
    const Made lower_before = lower;
    Matrix scratch(2, points);
    const auto all = stiction::press_families({upper.heights, upper.levels}, {lower.heights, lower.levels}, spacing,
                                              {amplitudes, measure}, approaches, models(), scratch);
    auto next = all.begin();
    std::vector<double> one(static_cast<std::size_t>(points));
    std::vector<double> other(one.size());
    for (Index row = 0; row < members; ++row) {
      for (const double amplitude : amplitudes) {
        REQUIRE(stiction::scale_to_amplitude(row_of(upper_before.heights, row), amplitude, measure, one));
        REQUIRE(stiction::scale_to_amplitude(row_of(lower_before.heights, row), amplitude, measure, other));
        for (const stiction::ContactModel& model : models()) {
          for (const stiction::Sums& alone : stiction::press({one, other, spacing}, approaches, model)) {
            REQUIRE(next != all.end());
            CHECK(numbers(*next) == numbers(alone));
            ++next;
          }
        }
      }
    }
    CHECK(next == all.end());
    CHECK(all.back().contact_count > 0);
  }
}

TEST_CASE("families refuse what cannot be pressed") {
  Made upper = family(1);
  Made lower = family(2);
  Matrix scratch(2, points);
  const std::array<double, 1> amplitude{0.1};
  const auto refuses = [&](Made& one, Made& other, Matrix& memory) {
    CHECK_THROWS_AS(
        stiction::press_families({one.heights, one.levels}, {other.heights, other.levels}, spacing,
                                 {amplitude, stiction::AmplitudeMeasure::height}, approaches, models(), memory),
        std::invalid_argument);
  };
  Made fewer{lower.heights.topRows(2), {lower.levels.begin(), lower.levels.begin() + 2}};
  refuses(upper, fewer, scratch);
  Made without_levels{lower.heights, {}};
  refuses(upper, without_levels, scratch);
  Matrix narrow(2, points - 1);
  refuses(upper, lower, narrow);
  Made flat{Matrix::Ones(members, points), std::vector<stiction::Level>(members, stiction::Level{1.0, 1.0, 1.0})};
  refuses(upper, flat, scratch);
}
