#include "stiction/harmonics.hpp"

#include "multiversion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>
#include <stdexcept>
#include <string>

namespace stiction {
namespace {

using Complex = std::complex<double>;

// Points that are computed together, so that the group profiles of one block stay in the second-level cache.
constexpr Index block = 2048;
// A harmonic is advanced this many points at a time, each by its own recurrence.
constexpr Index lanes = 32;
constexpr Index doublings = 5;
static_assert(lanes == 1 << doublings && block % lanes == 0);

// A phase as a fraction of a turn in 64 bits: multiples of it wrap exactly, however many turns they make.
using Turns = std::uint64_t;

Turns turns_of(long double turns) {
  const long double fraction = turns - std::rint(turns);  // [-1/2, 1/2]
  const long double scaled = std::ldexp(fraction, 64);
  constexpr long double half = 9223372036854775808.0L;
  return scaled >= half || scaled < -half ? Turns{1} << 63 : static_cast<Turns>(static_cast<std::int64_t>(scaled));
}

double radians(Turns turns) {
  return static_cast<double>(static_cast<std::int64_t>(turns)) * (std::numbers::pi * 0x1p-63);
}

Complex unit(Turns turns) { return std::polar(1.0, radians(turns)); }

// Re[amplitude e^(i k x)], as it is advanced along the grid.
struct Harmonic {
  Complex amplitude;                         // at x = 0
  Turns step;                                // k Δx
  std::array<Complex, doublings> rotations;  // e^(i k Δx), e^(2 i k Δx), ..., e^(lanes/2 i k Δx)
  Complex backward;                          // 1 - e^(-i lanes k Δx), to full relative accuracy
  double curvature;                          // 4 sin²(lanes k Δx / 2)

  Harmonic(Complex amplitude_at_zero, Turns turns_per_point) : amplitude(amplitude_at_zero), step(turns_per_point) {
    for (std::size_t w = 0; w < rotations.size(); ++w) {
      rotations[w] = unit(step << w);
    }
    const double half_angle = 0.5 * radians(step * static_cast<Turns>(lanes));
    backward = Complex(0.0, 2.0 * std::sin(half_angle)) * std::polar(1.0, -half_angle);
    curvature = 4.0 * std::sin(half_angle) * std::sin(half_angle);
  }
};

// The harmonics of one frequency n, and Σ_m cos φ_mn over those that are kept.
struct Group {
  std::vector<Harmonic> harmonics;
  double constant = 0.0;
};

// Directions m and M - m have opposite wave numbers: cos(-k x + φ') = cos(k x - φ'), so they make one harmonic of
// amplitude e^(i φ) + e^(-i φ'). m = M/2 has none and cancels; m = M has no partner.
std::vector<Group> groups(MatrixView phases, const HarmonicGrid& grid) {
  // Beyond this many turns along the profile, the fraction of a turn is no longer known to 1e-6.
  constexpr long double most_turns = 0x1p44L;
  const Index directions = phases.rows();
  std::vector<Group> result(static_cast<std::size_t>(phases.cols()));
  for (Index n = 0; n < phases.cols(); ++n) {
    Group& group = result[static_cast<std::size_t>(n)];
    const long double turns_per_point = std::pow(static_cast<long double>(grid.gamma), static_cast<long double>(n)) *
                                        static_cast<long double>(grid.spacing) /
                                        static_cast<long double>(grid.length_scale);
    const auto add = [&](Complex amplitude, long double turns) {
      if (grid.band_limited && std::abs(turns) > 0.5L) {
        return;
      }
      if (std::abs(turns) * static_cast<long double>(grid.points) > most_turns) {
        throw std::invalid_argument(
            "harmonic_profiles: gamma^(frequencies - 1) extent / length_scale is above 2^44, so the phases of the "
            "highest frequencies cannot be resolved; take a smaller gamma, fewer frequencies or a band limit");
      }
      group.harmonics.emplace_back(amplitude, turns_of(turns));
      group.constant += amplitude.real();
    };
    for (Index m = 1; 2 * m < directions; ++m) {
      const long double direction = std::cos(std::numbers::pi_v<long double> * static_cast<long double>(m) /
                                             static_cast<long double>(directions));
      add(std::polar(1.0, phases(m - 1, n)) + std::polar(1.0, -phases(directions - m - 1, n)),
          turns_per_point * direction);
    }
    add(std::polar(1.0, -phases(directions - 1, n)), turns_per_point);
  }
  return result;
}

// values[j] -= Re[z_j], z advancing by the recurrence d += -4 sin²(θ/2) z, z += d, whose error grows with the number of
// steps only, however small the angle θ is.
STICTION_MULTIVERSION
void subtract_recurrence(double* values, const double* start, const double* difference, double curvature) {
  double z[lanes];
  double d[lanes];
  for (Index lane = 0; lane < lanes; ++lane) {
    z[lane] = start[lane];
    d[lane] = difference[lane];
  }
  for (Index j = 0; j < block; j += lanes) {
    for (Index lane = 0; lane < lanes; ++lane) {
      values[j + lane] -= z[lane];
      d[lane] -= curvature * z[lane];
      z[lane] += d[lane];
    }
  }
}

void subtract_harmonic(const Harmonic& harmonic, Index first, double* values) {
  // The first `lanes` points by doubling: a run of points, then the same run rotated.
  std::array<double, lanes> real;
  std::array<double, lanes> imaginary;
  const Complex start = harmonic.amplitude * unit(harmonic.step * static_cast<Turns>(first));
  real[0] = start.real();
  imaginary[0] = start.imag();
  for (std::size_t w = 0, run = 1; w < harmonic.rotations.size(); ++w, run *= 2) {
    const double c = harmonic.rotations[w].real();
    const double s = harmonic.rotations[w].imag();
    for (std::size_t lane = 0; lane < run; ++lane) {
      real[run + lane] = c * real[lane] - s * imaginary[lane];
      imaginary[run + lane] = s * real[lane] + c * imaginary[lane];
    }
  }
  std::array<double, lanes> difference;  // Re[z_j - z_(j - lanes)]
  for (std::size_t lane = 0; lane < real.size(); ++lane) {
    difference[lane] = harmonic.backward.real() * real[lane] - harmonic.backward.imag() * imaginary[lane];
  }
  subtract_recurrence(values, real.data(), difference.data(), harmonic.curvature);
}

// sums[j] = Σ_n weights[n] values[n][j], in the order of n whatever the number of rows.
STICTION_MULTIVERSION
void weighted_sum(const double* weights, const double* values, Index frequencies, Index count, double* sums) {
  for (Index j = 0; j < count; ++j) {
    sums[j] = 0.0;
  }
  for (Index n = 0; n < frequencies; ++n) {
    const double weight = weights[n];
    const double* group = values + n * block;
    for (Index j = 0; j < count; ++j) {
      sums[j] += weight * group[j];
    }
  }
}

void require(bool condition, const char* what) {
  if (!condition) {
    throw std::invalid_argument(std::string("harmonic_profiles: ") + what);
  }
}

}  // namespace

std::vector<double> frequency_weights(double hurst_exponent, Index frequencies, double gamma, double length_scale) {
  if (!(gamma > 1.0) || !std::isfinite(gamma) || !(length_scale > 0.0) || !std::isfinite(length_scale)) {
    throw std::invalid_argument("frequency_weights: gamma must be above 1 and length_scale above 0");
  }
  std::vector<double> weights;
  for (Index n = 0; n < frequencies; ++n) {
    weights.push_back(std::pow(length_scale, hurst_exponent) * std::log(gamma) *
                      std::pow(gamma, -static_cast<double>(n) * hurst_exponent));
  }
  return weights;
}

Matrix harmonic_profiles(MatrixView phases, MatrixView weights, const HarmonicGrid& grid) {
  require(phases.rows() > 0 && phases.cols() > 0, "phases must have at least one direction and one frequency");
  require(weights.cols() == phases.cols(), "weights must have one column per frequency of the phases");
  require(phases.allFinite() && weights.allFinite(), "phases and weights must be finite");
  require(grid.points > 0, "points must be at least 1");
  require(grid.spacing > 0.0 && std::isfinite(grid.spacing), "spacing must be above 0 and finite");
  require(grid.length_scale > 0.0 && std::isfinite(grid.length_scale), "length_scale must be above 0 and finite");
  require(grid.gamma > 1.0 && std::isfinite(grid.gamma), "gamma must be above 1 and finite");

  const std::vector<Group> all = groups(phases, grid);
  Matrix profiles(weights.rows(), grid.points);
  std::vector<double> values(all.size() * static_cast<std::size_t>(block));
  for (Index first = 0; first < grid.points; first += block) {
    for (std::size_t n = 0; n < all.size(); ++n) {
      double* group = values.data() + static_cast<Index>(n) * block;
      std::fill_n(group, block, all[n].constant);
      for (const Harmonic& harmonic : all[n].harmonics) {
        subtract_harmonic(harmonic, first, group);
      }
    }
    const Index count = std::min(block, grid.points - first);
    for (Index row = 0; row < weights.rows(); ++row) {
      weighted_sum(weights.row(row).data(), values.data(), phases.cols(), count, profiles.row(row).data() + first);
    }
  }
  return profiles;
}

}  // namespace stiction
