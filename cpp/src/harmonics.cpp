#include "stiction/harmonics.hpp"

#include "multiversion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdint>
#include <limits>
#include <memory>
#include <new>
#include <numbers>
#include <stdexcept>
#include <string>

namespace stiction {
namespace {

using Complex = std::complex<double>;

// Arrays are aligned, because a SIMD load takes twice as long if it crosses the boundary of two cache lines.
constexpr std::size_t cache_line = 64;
struct AlignedDelete {
  void operator()(double* values) const { ::operator delete[](values, std::align_val_t{cache_line}); }
};
std::unique_ptr<double[], AlignedDelete> allocate_aligned(std::size_t size) {
  return std::unique_ptr<double[], AlignedDelete>(new (std::align_val_t{cache_line}) double[size]);
}

// Largest number of turns of a phase along the grid, as an exponent of 2. It leaves 20 bits for the fraction of a turn.
// The limit is 2^44 turns if a long double has a 64-bit mantissa, and 2^33 turns if its mantissa has 53 bits.
constexpr int max_turns_exponent = std::numeric_limits<long double>::digits - 20;

// Number of points per block. The profiles of all groups in one block must fit into the second-level cache.
constexpr Index block = 1024;
constexpr Index blocks_per_restart = 8;
// Number of recurrences per harmonic. Each recurrence computes every `lanes`-th point of the grid.
constexpr std::size_t lanes = 32;
constexpr std::size_t doublings = 5;
static_assert(lanes == 1 << doublings && block % lanes == 0);

// Phase in units of 2^-64 turns. Integer overflow removes whole turns exactly.
using Turns = std::uint64_t;

Turns to_turns(long double turns) {
  const long double fraction = turns - std::rint(turns);  // in [-1/2, 1/2]
  const long double scaled = std::ldexp(fraction, 64);
  constexpr long double half = 9223372036854775808.0L;
  return scaled >= half || scaled < -half ? Turns{1} << 63 : static_cast<Turns>(static_cast<std::int64_t>(scaled));
}

double to_radians(Turns turns) {
  return static_cast<double>(static_cast<std::int64_t>(turns)) * (std::numbers::pi * 0x1p-63);
}

Complex unit_phasor(Turns turns) { return std::polar(1.0, to_radians(turns)); }

// Harmonic Re[A e^(i k x)]. With θ = `lanes` k Δx, the recurrence d -= 4 sin²(θ/2) z, z += d advances `lanes` points.
// The round-off of the recurrence is proportional to the number of steps, even for very small θ.
struct Harmonic {
  alignas(cache_line) std::array<double, lanes> z;  // values at the next `lanes` points
  // `z` minus the values at the preceding `lanes` points.
  alignas(cache_line) std::array<double, lanes> d;
  double rate;                               // 4 sin²(θ/2)
  Complex amplitude;                         // at x = 0
  Complex backward;                          // 1 - e^(-i θ), to full relative accuracy
  std::array<Complex, doublings> rotations;  // e^(i k Δx), e^(2 i k Δx), ..., e^(lanes/2 i k Δx)
  Turns step;                                // k Δx

  Harmonic(Complex amplitude_at_zero, Turns turns_per_point) : amplitude(amplitude_at_zero), step(turns_per_point) {
    for (std::size_t w = 0; w < rotations.size(); ++w) {
      rotations[w] = unit_phasor(step << w);
    }
    const double half_angle = 0.5 * to_radians(step * static_cast<Turns>(lanes));
    backward = Complex(0.0, 2.0 * std::sin(half_angle)) * std::polar(1.0, -half_angle);
    rate = 4.0 * std::sin(half_angle) * std::sin(half_angle);
  }

  // The first `lanes` values are computed by doubling: n known values times e^(i k n Δx) are the following n values.
  STICTION_MULTIVERSION void start(Index point) {
    std::array<double, lanes> imaginary;
    const Complex first = amplitude * unit_phasor(step * static_cast<Turns>(point));
    z[0] = first.real();
    imaginary[0] = first.imag();
    for (std::size_t w = 0, run = 1; w < rotations.size(); ++w, run *= 2) {
      const double c = rotations[w].real();
      const double s = rotations[w].imag();
      for (std::size_t lane = 0; lane < run; ++lane) {
        z[run + lane] = c * z[lane] - s * imaginary[lane];
        imaginary[run + lane] = s * z[lane] + c * imaginary[lane];
      }
    }
    for (std::size_t lane = 0; lane < z.size(); ++lane) {
      d[lane] = backward.real() * z[lane] - backward.imag() * imaginary[lane];
    }
  }
};

// Harmonics of one frequency n, and the sum of cos φ_mn over these harmonics.
struct Group {
  std::vector<Harmonic> harmonics;
  double constant = 0.0;
};

// Directions m and M - m have opposite wavenumbers, so they form one harmonic with the amplitude e^(i φ) + e^(-i φ').
// In direction m = M/2, the wavenumber is 0, so the harmonic is 0. Direction m = M has no opposite direction.
std::vector<Group> make_groups(MatrixView phases, const HarmonicGrid& grid) {
  const long double max_turns = std::ldexp(1.0L, max_turns_exponent);
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
      if (std::abs(turns) * static_cast<long double>(grid.points) > max_turns) {
        throw std::invalid_argument(
            "harmonic_profiles: gamma^(frequencies - 1) extent / length_scale must be at most 2^" +
            std::to_string(max_turns_exponent) +
            ", because the phases of higher frequencies cannot be resolved; use a smaller gamma, fewer frequencies or "
            "a "
            "band limit");
      }
      group.harmonics.emplace_back(amplitude, to_turns(turns));
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

// `count` harmonics are subtracted in one pass, which loads and stores each height once and keeps z and d in registers.
template <std::size_t Width, std::size_t count>
STICTION_INLINE void subtract(double* values, Harmonic* harmonics) {
  constexpr std::size_t packs = Width == 8 ? 4 : 2;
  for (std::size_t lane = 0; lane < lanes; lane += packs * Width) {
    Pack<Width> z[count][packs];
    Pack<Width> d[count][packs];
    for (std::size_t h = 0; h < count; ++h) {
      for (std::size_t p = 0; p < packs; ++p) {
        z[h][p] = load<Width>(harmonics[h].z.data() + lane + p * Width);
        d[h][p] = load<Width>(harmonics[h].d.data() + lane + p * Width);
      }
    }
    for (std::size_t j = lane; j < block; j += lanes) {
      for (std::size_t p = 0; p < packs; ++p) {
        Pack<Width> value = load<Width>(values + j + p * Width);
        for (std::size_t h = 0; h < count; ++h) {
          value -= z[h][p];
          d[h][p] -= harmonics[h].rate * z[h][p];
          z[h][p] += d[h][p];
        }
        store<Width>(value, values + j + p * Width);
      }
    }
    for (std::size_t h = 0; h < count; ++h) {
      for (std::size_t p = 0; p < packs; ++p) {
        store<Width>(z[h][p], harmonics[h].z.data() + lane + p * Width);
        store<Width>(d[h][p], harmonics[h].d.data() + lane + p * Width);
      }
    }
  }
}

template <std::size_t Width>
STICTION_INLINE void subtract_two_kernel(double* values, Harmonic* harmonics) {
  subtract<Width, 2>(values, harmonics);
}

template <std::size_t Width>
STICTION_INLINE void subtract_one_kernel(double* values, Harmonic* harmonics) {
  subtract<Width, 1>(values, harmonics);
}

STICTION_KERNEL(subtract_two, (double* values, Harmonic* harmonics), (values, harmonics))
STICTION_KERNEL(subtract_one, (double* values, Harmonic* harmonics), (values, harmonics))

STICTION_MULTIVERSION
void fill_block(double* values, double constant) { std::fill_n(values, block, constant); }

// Compute the next block of a group's profile. Blocks must be computed one after the other, from left to right.
void next_block(Group& group, Index first, double* values) {
  fill_block(values, group.constant);
  if (first % (blocks_per_restart * block) == 0) {
    for (Harmonic& harmonic : group.harmonics) {
      harmonic.start(first);
    }
  }
  std::size_t h = 0;
  for (; h + 2 <= group.harmonics.size(); h += 2) {
    subtract_two(values, &group.harmonics[h]);
  }
  if (h < group.harmonics.size()) {
    subtract_one(values, &group.harmonics[h]);
  }
}

// Compute sums(row, j) = Σ_n weights(row, n) values[n][j] for all points j of a block.
// A tile of sums stays in registers for all frequencies n. Its size does not change the order of additions.
template <std::size_t Width, std::size_t rows, std::size_t packs>
STICTION_INLINE void tile_product(const double* weights, const double* values, std::size_t frequencies, double* sums,
                                  std::size_t stride) {
  static_assert(block % (packs * Width) == 0);
  for (std::size_t j = 0; j < block; j += packs * Width) {
    Pack<Width> tile[rows][packs] = {};
    for (std::size_t n = 0; n < frequencies; ++n) {
      for (std::size_t row = 0; row < rows; ++row) {
        for (std::size_t p = 0; p < packs; ++p) {
          tile[row][p] += weights[row * frequencies + n] * load<Width>(values + n * block + j + p * Width);
        }
      }
    }
    for (std::size_t row = 0; row < rows; ++row) {
      for (std::size_t p = 0; p < packs; ++p) {
        store<Width>(tile[row][p], sums + row * stride + j + p * Width);
      }
    }
  }
}

// Ten rows of sums are computed together, because each loaded value is then used ten times.
template <std::size_t Width>
STICTION_INLINE void ten_rows_kernel(const double* weights, const double* values, std::size_t frequencies, double* sums,
                                     std::size_t stride) {
  tile_product<Width, 10, Width == 8 ? 2 : 1>(weights, values, frequencies, sums, stride);
}

template <std::size_t Width>
STICTION_INLINE void four_rows_kernel(const double* weights, const double* values, std::size_t frequencies,
                                      double* sums, std::size_t stride) {
  tile_product<Width, 4, Width == 8 ? 4 : 2>(weights, values, frequencies, sums, stride);
}

template <std::size_t Width>
STICTION_INLINE void one_row_kernel(const double* weights, const double* values, std::size_t frequencies, double* sums,
                                    std::size_t stride) {
  tile_product<Width, 1, 8>(weights, values, frequencies, sums, stride);
}

STICTION_KERNEL(ten_rows,
                (const double* weights, const double* values, std::size_t frequencies, double* sums,
                 std::size_t stride),
                (weights, values, frequencies, sums, stride))
STICTION_KERNEL(four_rows,
                (const double* weights, const double* values, std::size_t frequencies, double* sums,
                 std::size_t stride),
                (weights, values, frequencies, sums, stride))
STICTION_KERNEL(one_row,
                (const double* weights, const double* values, std::size_t frequencies, double* sums,
                 std::size_t stride),
                (weights, values, frequencies, sums, stride))

// Calls `after(begin, end)` as soon as rows `begin` to `end - 1` are complete, while they are still in the cache.
template <class After>
void product(const Eigen::Map<const Matrix>& weights, const double* values, double* sums, Index stride,
             const After& after) {
  const Index rows = weights.rows();
  const auto frequencies = static_cast<std::size_t>(weights.cols());
  const auto step = static_cast<std::size_t>(stride);
  Index done = 0;
  for (; done + 10 <= rows; done += 10) {
    ten_rows(weights.row(done).data(), values, frequencies, sums + done * stride, step);
    after(done, done + 10);
  }
  if (rows >= 4) {
    for (; done < rows; done += 4) {
      const Index row = std::min(done, rows - 4);  // the last tile may overlap the previous tile
      four_rows(weights.row(row).data(), values, frequencies, sums + row * stride, step);
      after(done, row + 4);
    }
    return;
  }
  for (; done < rows; ++done) {
    one_row(weights.row(done).data(), values, frequencies, sums + done * stride, step);
    after(done, done + 1);
  }
}

constexpr Index points_per_run = 64;
static_assert(block % points_per_run == 0);

// Rotate a table of cosines and sines. Adding the phase difference at each point would accumulate more round-off.
STICTION_MULTIVERSION
void rotate_table(const double* table_cos, const double* table_sin, double c, double s, double* cosines,
                  double* sines) {
  for (Index l = 0; l < points_per_run; ++l) {
    cosines[l] = c * table_cos[l] - s * table_sin[l];
    sines[l] = c * table_sin[l] + s * table_cos[l];
  }
}

struct Rotations {
  std::array<double, points_per_run> cosines;
  std::array<double, points_per_run> sines;
  Turns step;

  explicit Rotations(Turns turns_per_point) : step(turns_per_point) {
    for (std::size_t l = 0; l < points_per_run; ++l) {
      const Complex at = unit_phasor(step * static_cast<Turns>(l));
      cosines[l] = at.real();
      sines[l] = at.imag();
    }
  }

  void fill(Index first, double* cosine, double* sine) const {
    const Complex at = unit_phasor(step * static_cast<Turns>(first));
    rotate_table(cosines.data(), sines.data(), at.real(), at.imag(), cosine, sine);
  }
};

// Directions m and M - m have opposite wavenumbers along x and equal wavenumbers along y.
// The harmonics of m and M - m add up to -w Re[even e^(i Y)] cos X + w Im[odd e^(i Y)] sin X.
// The factors are even = e^(i φ) + e^(i φ') and odd = e^(i φ) - e^(i φ'), or e^(i φ) for a direction without partner.
struct ArealHarmonic {
  Complex even;
  Complex odd;
  Rotations along_y;
  Rotations along_x;
};

// Wavenumbers along y and x [turns per point]. Directions m and M - m differ only in the sign of `x`.
struct Wavenumbers {
  long double y;
  long double x;
};

Wavenumbers pair_wavenumbers(const HarmonicArea& area, Index m, Index directions, Index n) {
  const long double number = std::pow(static_cast<long double>(area.gamma), static_cast<long double>(n)) /
                             static_cast<long double>(area.length_scale);
  const long double angle =
      std::numbers::pi_v<long double> * static_cast<long double>(m) / static_cast<long double>(directions);
  return {number * std::sin(angle) * static_cast<long double>(area.spacing_y),
          number * std::cos(angle) * static_cast<long double>(area.spacing_x)};
}

// Harmonics whose amplitudes include the weights w, and `constant`, the sum of w cos φ over all harmonics.
struct ArealSum {
  std::vector<ArealHarmonic> harmonics;
  double constant = 0.0;
};

ArealSum make_areal_sum(MatrixView phases, Values weights, const HarmonicArea& area, Index rows, Index columns) {
  const long double max_turns = std::ldexp(1.0L, max_turns_exponent);
  ArealSum sum;
  const Index directions = phases.rows();
  for (Index n = 0; n < phases.cols(); ++n) {
    const double weight = weights[static_cast<std::size_t>(n)];
    for (Index m = 1; m <= directions; ++m) {
      const Index partner = directions - m;
      if (partner > 0 && partner < m) {
        continue;
      }
      const Wavenumbers turns = pair_wavenumbers(area, m, directions, n);
      if (area.band_limited && (std::abs(turns.y) > 0.5L || std::abs(turns.x) > 0.5L)) {
        continue;
      }
      if (std::max(std::abs(turns.y) * static_cast<long double>(rows),
                   std::abs(turns.x) * static_cast<long double>(columns)) > max_turns) {
        throw std::invalid_argument(
            "harmonic_surface: gamma^(frequencies - 1) extent / length_scale must be at most 2^" +
            std::to_string(max_turns_exponent) +
            ", because the phases of higher frequencies cannot be resolved; use a smaller gamma, fewer frequencies, a "
            "smaller extent or a band limit");
      }
      const Complex wave = std::polar(weight, phases(m - 1, n));
      const bool has_no_partner = partner == 0 || partner == m;
      const Complex partner_wave = has_no_partner ? Complex(0.0, 0.0) : std::polar(weight, phases(partner - 1, n));
      sum.harmonics.push_back(
          {wave + partner_wave, wave - partner_wave, Rotations(to_turns(turns.y)), Rotations(to_turns(turns.x))});
      sum.constant += (wave + partner_wave).real();
    }
  }
  return sum;
}

void require(bool condition, const char* message) {
  if (!condition) {
    throw std::invalid_argument(std::string("harmonics: ") + message);
  }
}

}  // namespace

std::vector<double> frequency_weights(double hurst_exponent, Index frequencies, double gamma, double length_scale) {
  if (!(gamma > 1.0) || !std::isfinite(gamma) || !(length_scale > 0.0) || !std::isfinite(length_scale)) {
    throw std::invalid_argument("frequency_weights: gamma must be above 1 and length_scale above 0");
  }
  std::vector<double> weights;
  weights.reserve(static_cast<std::size_t>(frequencies));
  for (Index n = 0; n < frequencies; ++n) {
    weights.push_back(std::pow(length_scale, hurst_exponent) * std::log(gamma) *
                      std::pow(gamma, -static_cast<double>(n) * hurst_exponent));
  }
  return weights;
}

std::vector<HeightStatistics> harmonic_profiles(MatrixView phases, MatrixView weights, const HarmonicGrid& grid,
                                                Eigen::Ref<Matrix> profiles,
                                                const CancellationCheck& check_cancellation) {
  require(phases.rows() > 0 && phases.cols() > 0, "phases must have at least one direction and one frequency");
  require(weights.cols() == phases.cols(), "weights must have one column per frequency of the phases");
  require(phases.allFinite() && weights.allFinite(), "phases and weights must be finite");
  require(grid.points > 0, "points must be at least 1");
  require(grid.spacing > 0.0 && std::isfinite(grid.spacing), "spacing must be above 0 and finite");
  require(grid.length_scale > 0.0 && std::isfinite(grid.length_scale), "length_scale must be above 0 and finite");
  require(grid.gamma > 1.0 && std::isfinite(grid.gamma), "gamma must be above 1 and finite");
  require(profiles.rows() == weights.rows() && profiles.cols() == grid.points,
          "profiles must have a row for each row of weights and a column for each point");

  if (weights.rows() == 0) {
    return {};
  }
  std::vector<Group> all_groups = make_groups(phases, grid);
  const auto packed = allocate_aligned(static_cast<std::size_t>(weights.size()));
  Eigen::Map<Matrix>(packed.get(), weights.rows(), weights.cols()) = weights;
  const Eigen::Map<const Matrix> packed_weights(packed.get(), weights.rows(), weights.cols());
  const auto values = allocate_aligned(all_groups.size() * block);
  std::vector<HeightAccumulator> accumulators(static_cast<std::size_t>(weights.rows()));
  for (Index first = 0; first < grid.points; first += block) {
    for (std::size_t n = 0; n < all_groups.size(); ++n) {
      check_cancellation();
      next_block(all_groups[n], first, values.get() + n * block);
    }
    const Index count = std::min(grid.points - first, block);
    const auto accumulate = [&](Index begin, Index end) {
      for (Index row = begin; row < end; ++row) {
        const double* heights = profiles.row(row).data() + first;
        accumulators[static_cast<std::size_t>(row)].add({heights, static_cast<std::size_t>(count)});
      }
    };
    if (count == block) {
      product(packed_weights, values.get(), profiles.data() + first, profiles.outerStride(), accumulate);
    } else {
      const auto buffer = allocate_aligned(static_cast<std::size_t>(weights.rows() * block));
      const Eigen::Map<Matrix> last_block(buffer.get(), weights.rows(), block);
      product(packed_weights, values.get(), buffer.get(), block, [](Index, Index) {});
      profiles.rightCols(count) = last_block.leftCols(count);
      accumulate(0, weights.rows());
    }
  }
  std::vector<HeightStatistics> statistics;
  statistics.reserve(accumulators.size());
  for (const HeightAccumulator& accumulator : accumulators) {
    statistics.push_back(accumulator.statistics());
  }
  return statistics;
}

void harmonic_surface(MatrixView phases, Values weights, const HarmonicArea& area, Eigen::Ref<Matrix> heights,
                      const CancellationCheck& check_cancellation) {
  const Index rows = heights.rows();
  const Index columns = heights.cols();
  require(phases.rows() > 0 && phases.cols() > 0, "phases must have at least one direction and one frequency");
  require(static_cast<Index>(weights.size()) == phases.cols(),
          "weights must have one element for each frequency of the phases");
  require(phases.allFinite(), "phases must be finite");
  require(
      area.spacing_y > 0.0 && std::isfinite(area.spacing_y) && area.spacing_x > 0.0 && std::isfinite(area.spacing_x),
      "spacings must be above 0 and finite");
  require(area.length_scale > 0.0 && std::isfinite(area.length_scale), "length_scale must be above 0 and finite");
  require(area.gamma > 1.0 && std::isfinite(area.gamma), "gamma must be above 1 and finite");

  const ArealSum sum = make_areal_sum(phases, weights, area, rows, columns);
  heights.setConstant(sum.constant);
  // The surface is computed in tiles, with a few harmonics per pass, so that the factors of a pass stay in the cache.
  constexpr std::size_t harmonics_per_pass = 32;
  const auto x_factors = allocate_aligned(2 * harmonics_per_pass * block);
  std::array<double, points_per_run> cosines;
  std::array<double, points_per_run> sines;
  const auto tile_values = allocate_aligned(points_per_run * block);
  const Eigen::Map<const Matrix> tile(tile_values.get(), points_per_run, block);
  const auto factors = allocate_aligned(points_per_run * 2 * harmonics_per_pass);
  for (Index column = 0; column < columns; column += block) {
    const Index width = std::min(block, columns - column);
    for (std::size_t begin = 0; begin < sum.harmonics.size(); begin += harmonics_per_pass) {
      const std::size_t count = std::min(harmonics_per_pass, sum.harmonics.size() - begin);
      for (std::size_t h = 0; h < count; ++h) {
        double* values = x_factors.get() + 2 * h * block;
        for (Index j = 0; j < width; j += points_per_run) {
          sum.harmonics[begin + h].along_x.fill(column + j, values + j, values + block + j);
        }
      }
      Eigen::Map<Matrix> y_factors(factors.get(), points_per_run, static_cast<Index>(2 * count));
      for (Index row = 0; row < rows; row += points_per_run) {
        check_cancellation();
        for (std::size_t h = 0; h < count; ++h) {
          const ArealHarmonic& harmonic = sum.harmonics[begin + h];
          harmonic.along_y.fill(row, cosines.data(), sines.data());
          for (std::size_t i = 0; i < points_per_run; ++i) {
            const auto row_in_run = static_cast<Index>(i);
            y_factors(row_in_run, static_cast<Index>(2 * h)) =
                -(harmonic.even.real() * cosines[i] - harmonic.even.imag() * sines[i]);
            y_factors(row_in_run, static_cast<Index>(2 * h + 1)) =
                harmonic.odd.real() * sines[i] + harmonic.odd.imag() * cosines[i];
          }
        }
        product({y_factors.data(), y_factors.rows(), y_factors.cols()}, x_factors.get(), tile_values.get(), block,
                [](Index, Index) {});
        const Index height = std::min(points_per_run, rows - row);
        heights.block(row, column, height, width) += tile.topLeftCorner(height, width);
      }
    }
  }
}

}  // namespace stiction
