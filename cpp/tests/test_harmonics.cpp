#include "stiction/harmonics.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <random>

using stiction::HarmonicGrid;
using stiction::Index;
using stiction::Matrix;

namespace {

Matrix random_phases(Index directions, Index frequencies) {
  std::mt19937_64 random(11);
  Matrix phases(directions, frequencies);
  for (double& phase : phases.reshaped()) {
    phase = 2.0 * std::numbers::pi * static_cast<double>(random() >> 11) * 0x1p-53;
  }
  return phases;
}

// Sum of Eq. 1 of Hanaor, Gan & Einav (2016), evaluated term by term, with phases in extended precision.
double direct_sum(const Matrix& phases, const std::vector<double>& weights, const HarmonicGrid& grid, Index point) {
  constexpr long double pi = std::numbers::pi_v<long double>;
  long double sum = 0.0L;
  for (Index n = 0; n < phases.cols(); ++n) {
    for (Index m = 1; m <= phases.rows(); ++m) {
      const long double wave_number =
          2.0L * pi * std::pow(static_cast<long double>(grid.gamma), static_cast<long double>(n)) /
          static_cast<long double>(grid.length_scale) *
          std::cos(pi * static_cast<long double>(m) / static_cast<long double>(phases.rows()));
      if (grid.band_limited && std::abs(wave_number * static_cast<long double>(grid.spacing)) > pi) {
        continue;
      }
      const auto phase = static_cast<long double>(phases(m - 1, n));
      const long double x = static_cast<long double>(point) * static_cast<long double>(grid.spacing);
      sum += static_cast<long double>(weights[static_cast<std::size_t>(n)]) *
             (std::cos(phase) - std::cos(wave_number * x + phase));
    }
  }
  return static_cast<double>(sum);
}

}  // namespace

TEST_CASE(
    "harmonic_profiles: matches the direct sum for odd and even numbers of directions, with and without aliasing") {
  // The tolerance is the round-off of block / lanes steps of a recurrence, times the sum of some hundred amplitudes.
  constexpr double tolerance = 2e-13;
  for (const Index directions : {1, 2, 7, 40}) {
    for (const bool band_limited : {false, true}) {
      const Matrix phases = random_phases(directions, 24);
      const HarmonicGrid grid{0.003, 5000, 1.25, 1.5, band_limited};
      const std::vector<double> weights = stiction::frequency_weights(0.6, 24, grid.gamma, grid.length_scale);
      const Matrix row = Eigen::Map<const Matrix>(weights.data(), 1, 24);
      const Matrix profile = stiction::harmonic_profiles(phases, row, grid);
      for (const Index point : {0, 1, 31, 32, 2047, 2048, 4999}) {
        CHECK(std::abs(profile(0, point) - direct_sum(phases, weights, grid, point)) <
              tolerance * static_cast<double>(directions));
      }
    }
  }
}

TEST_CASE("harmonic_profiles: a row does not depend on the other rows") {
  const Matrix phases = random_phases(8, 6);
  const Matrix weights = random_phases(5, 6);
  const HarmonicGrid grid{0.01, 3000};
  const Matrix family = stiction::harmonic_profiles(phases, weights, grid);
  for (Index row = 0; row < weights.rows(); ++row) {
    CHECK(stiction::harmonic_profiles(phases, weights.row(row), grid) == family.row(row));
  }
}

TEST_CASE("harmonic_profiles: invalid arguments and unresolvable phases throw") {
  const Matrix phases = random_phases(4, 6);
  const Matrix weights = Matrix::Ones(1, 6);
  const auto refuses = [&](const Matrix& p, const Matrix& w, const HarmonicGrid& grid) {
    CHECK_THROWS_AS(stiction::harmonic_profiles(p, w, grid), std::invalid_argument);
  };
  refuses(phases, Matrix::Ones(1, 5), {0.01, 10});
  refuses(Matrix(0, 0), Matrix(1, 0), {0.01, 10});
  refuses(phases, weights, {0.0, 10});
  refuses(phases, weights, {0.01, 0});
  refuses(phases, weights, {0.01, 10, -1.0});
  refuses(phases, weights, {0.01, 10, 1.0, 1.0});
  // A long double cannot resolve a phase of 1e40 turns, not even with the 113-bit mantissa on aarch64.
  refuses(phases, weights, {0.01, 10, 1.0, 1e8});
  CHECK_NOTHROW(stiction::harmonic_profiles(phases, weights, {0.01, 10, 1.0, 1e8, true}));
}
