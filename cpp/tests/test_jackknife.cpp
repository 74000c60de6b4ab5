#include "stiction/jackknife.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

using stiction::Index;
using stiction::Matrix;

namespace {

constexpr Index curves = 3;
constexpr Index steps = 4;

// Random values, a few of which are much larger than all others.
Matrix random_values(Index repetitions, unsigned seed) {
  std::mt19937_64 random(seed);
  Matrix values(curves * steps, repetitions);
  for (double& value : values.reshaped()) {
    const double uniform = static_cast<double>(random() >> 11) * 0x1p-53;
    value = 1.0 / (0.001 + uniform);
  }
  return values;
}

long double interpolate(const Matrix& values, Index row, double fraction, Index repetition) {
  const auto before = static_cast<long double>(values(row - 1, repetition));
  return before + static_cast<long double>(fraction) * (static_cast<long double>(values(row, repetition)) - before);
}

double average(const Matrix& values, Index row, double fraction) {
  long double sum = 0.0L;
  for (Index repetition = 0; repetition < values.cols(); ++repetition) {
    sum += interpolate(values, row, fraction, repetition);
  }
  return static_cast<double>(sum / static_cast<long double>(values.cols()));
}

}  // namespace

TEST_CASE("jackknife_sums: match sums of single repetitions in extended precision") {
  // The tolerance is the round-off of adding some hundred doubles, divided by the sum of their magnitudes.
  constexpr long double tolerance = 1e-14L;
  const std::vector<Index> curve{0, 1, 2, 2};
  const std::vector<Index> step{1, 3, 2, 2};
  const std::vector<double> fraction{0.25, 1.0, 0.0, 0.7};
  const std::vector<double> slope{0.5, 1.5, 0.0, -2.0};
  // Leaving out one of few repetitions changes the mean by a large fraction. 300 repetitions end within a chunk.
  for (const Index repetitions : {2, 5, 100, 300}) {
    const Matrix loads = random_values(repetitions, 1);
    const Matrix values = random_values(repetitions, 2);
    for (const bool is_shared : {false, true}) {
      std::vector<double> load;
      std::vector<double> mean;
      for (std::size_t i = 0; i < curve.size(); ++i) {
        load.push_back(average(loads, curve[i] * steps + step[i], fraction[i]));
        mean.push_back(average(values, (is_shared ? 0 : curve[i]) * steps + step[i], fraction[i]));
      }
      Matrix sums(stiction::jackknife_sum_rows, 4);
      stiction::jackknife_sums(
          {curve, step, fraction, load, mean, slope}, {loads.data(), steps * repetitions, repetitions},
          {values.data(), is_shared ? 0 : steps * repetitions, repetitions}, repetitions, repetitions, sums);
      for (std::size_t i = 0; i < curve.size(); ++i) {
        std::array<long double, 8> expected{};
        std::array<long double, 8> magnitudes{};
        long double min_change = 1.0L;
        long double min_load_change = 1.0L;
        for (Index repetition = 0; repetition < repetitions; ++repetition) {
          const auto others = static_cast<long double>(repetitions - 1);
          const auto mean_load = static_cast<long double>(load[i]);
          const auto mean_value = static_cast<long double>(mean[i]);
          const long double load_change =
              (mean_load - interpolate(loads, curve[i] * steps + step[i], fraction[i], repetition)) / others;
          const Index row = (is_shared ? 0 : curve[i]) * steps + step[i];
          const long double change = (mean_value - interpolate(values, row, fraction[i], repetition)) / others;
          const auto derivative = static_cast<long double>(slope[i]);
          const long double logarithm = std::log1p(change / mean_value) -
                                        derivative * mean_load / mean_value * std::log1p(load_change / mean_load);
          const long double difference = change - derivative * load_change;
          for (std::size_t power = 0; power < 4; ++power) {
            const auto exponent = static_cast<int>(power) + 1;
            expected[power] += std::pow(logarithm, exponent);
            expected[4 + power] += std::pow(difference, exponent);
            magnitudes[power] += std::pow(std::abs(logarithm), exponent);
            magnitudes[4 + power] += std::pow(std::abs(difference), exponent);
          }
          min_change = std::min(min_change, change / mean_value);
          min_load_change = std::min(min_load_change, load_change / mean_load);
        }
        const auto column = static_cast<Index>(i);
        for (std::size_t row = 0; row < expected.size(); ++row) {
          const auto sum = static_cast<long double>(sums(static_cast<Index>(row), column));
          CHECK(std::abs(sum - expected[row]) <= tolerance * magnitudes[row]);
        }
        CHECK(std::abs(static_cast<long double>(sums(8, column)) - min_change) <= tolerance);
        CHECK(std::abs(static_cast<long double>(sums(9, column)) - min_load_change) <= tolerance);
      }
    }
  }
}

TEST_CASE("jackknife_sums: are not finite if one repetition has no value") {
  Matrix loads = random_values(40, 1);
  Matrix values = random_values(40, 2);
  values(1, 17) = std::nan("");
  const std::vector<Index> curve{0};
  const std::vector<Index> step{1};
  const std::vector<double> fraction{0.5};
  const std::vector<double> one{1.0};
  Matrix sums(stiction::jackknife_sum_rows, 1);
  stiction::jackknife_sums({curve, step, fraction, one, one, one}, {loads.data(), steps * 40, 40},
                           {values.data(), steps * 40, 40}, 40, 40, sums);
  CHECK(sums.topRows(8).array().isNaN().all());
}
