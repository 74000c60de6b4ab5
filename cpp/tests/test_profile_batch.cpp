#include "stiction/harmonics.hpp"
#include "stiction/profile_batch.hpp"

#include <doctest/doctest.h>

#include <array>
#include <numbers>
#include <random>
#include <stdexcept>
#include <vector>

namespace {

using stiction::Index;
using stiction::Matrix;

constexpr Index points = 3000;  // number of points; neither a multiple of the block size nor of the chunk size
constexpr Index rows = 3;
constexpr double spacing = 0.002;
const std::vector<double> approaches{0.002, 0.01, 0.03};

struct Batch {
  Matrix heights;
  std::vector<stiction::HeightStatistics> statistics;
};

Batch make_batch(unsigned seed) {
  std::mt19937_64 random(seed);
  Matrix phases(8, 12);
  for (double& phase : phases.reshaped()) {
    phase = 2.0 * std::numbers::pi * static_cast<double>(random() >> 11) * 0x1p-53;
  }
  Matrix weights(rows, phases.cols());
  for (Index row = 0; row < rows; ++row) {
    const auto of_row = stiction::frequency_weights(0.8 + 0.3 * static_cast<double>(row), phases.cols(), 1.5, 1.0);
    weights.row(row) = Eigen::Map<const Eigen::RowVectorXd>(of_row.data(), phases.cols());
  }
  Batch batch{Matrix(rows, points), {}};
  batch.statistics = stiction::harmonic_profiles(phases, weights, {spacing, points}, batch.heights);
  return batch;
}

stiction::Values row_of(const Matrix& heights, Index row) {
  return {heights.row(row).data(), static_cast<std::size_t>(heights.cols())};
}

std::vector<double> to_numbers(const stiction::Sums& sums) {
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

TEST_CASE("harmonic_profiles: height statistics are bit-identical to those of the complete rows") {
  const Batch batch = make_batch(1);
  for (Index row = 0; row < rows; ++row) {
    stiction::HeightAccumulator whole;
    whole.add(row_of(batch.heights, row));
    const stiction::HeightStatistics& statistics = batch.statistics[static_cast<std::size_t>(row)];
    CHECK(statistics.mean == whole.statistics().mean);
    CHECK(statistics.min == batch.heights.row(row).minCoeff());
    CHECK(statistics.max == batch.heights.row(row).maxCoeff());
  }
}

TEST_CASE("press_profile_batches: results are bit-identical to scaling and pressing each pair separately") {
  const std::vector<double> amplitudes{0.05, 0.1};
  for (const auto measure : {stiction::AmplitudeMeasure::height, stiction::AmplitudeMeasure::rq}) {
    Batch upper = make_batch(1);
    Batch lower = make_batch(2);
    const Batch upper_before = upper;
    const Batch lower_before = lower;
    Matrix scratch(2, points);
    const auto all =
        stiction::press_profile_batches({upper.heights, upper.statistics}, {lower.heights, lower.statistics}, spacing,
                                        {amplitudes, measure}, approaches, models(), scratch);
    auto next = all.begin();
    std::vector<double> upper_scaled(static_cast<std::size_t>(points));
    std::vector<double> lower_scaled(upper_scaled.size());
    for (Index row = 0; row < rows; ++row) {
      for (const double amplitude : amplitudes) {
        REQUIRE(stiction::scale_to_amplitude(row_of(upper_before.heights, row), amplitude, measure, upper_scaled));
        REQUIRE(stiction::scale_to_amplitude(row_of(lower_before.heights, row), amplitude, measure, lower_scaled));
        for (const stiction::ContactModel& model : models()) {
          for (const stiction::Sums& expected :
               stiction::press({upper_scaled, lower_scaled, spacing}, approaches, model)) {
            REQUIRE(next != all.end());
            CHECK(to_numbers(*next) == to_numbers(expected));
            ++next;
          }
        }
      }
    }
    CHECK(next == all.end());
    CHECK(all.back().contact_count > 0);
  }
}

TEST_CASE("press_profile_batches: mismatched shapes and flat profiles throw") {
  Batch upper = make_batch(1);
  Batch lower = make_batch(2);
  Matrix scratch(2, points);
  const std::array<double, 1> amplitude{0.1};
  const auto refuses = [&](Batch& upper_scaled, Batch& lower_scaled, Matrix& memory) {
    CHECK_THROWS_AS(
        stiction::press_profile_batches({upper_scaled.heights, upper_scaled.statistics},
                                        {lower_scaled.heights, lower_scaled.statistics}, spacing,
                                        {amplitude, stiction::AmplitudeMeasure::height}, approaches, models(), memory),
        std::invalid_argument);
  };
  Batch fewer{lower.heights.topRows(2), {lower.statistics.begin(), lower.statistics.begin() + 2}};
  refuses(upper, fewer, scratch);
  Batch without_levels{lower.heights, {}};
  refuses(upper, without_levels, scratch);
  Matrix narrow(2, points - 1);
  refuses(upper, lower, narrow);
  Batch flat{Matrix::Ones(rows, points),
             std::vector<stiction::HeightStatistics>(rows, stiction::HeightStatistics{1.0, 1.0, 1.0})};
  refuses(upper, flat, scratch);
}
