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

// Memory from the beginning of a line of the cache on: a wide read across two lines costs two.
constexpr std::size_t line = 64;
struct Free {
  void operator()(double* values) const { ::operator delete[](values, std::align_val_t{line}); }
};
std::unique_ptr<double[], Free> aligned(std::size_t size) {
  return std::unique_ptr<double[], Free>(new (std::align_val_t{line}) double[size]);
}

// Of a grid's turns, as a power of two: more along all of it leave less than 20 binary digits, 1e-6, for the fraction
// of a turn. 2^44 where a long double has 64 digits, 2^33 where it is a double.
constexpr int resolved_turns = std::numeric_limits<long double>::digits - 20;

// Points that are computed together, so that the group profiles of one block stay in the second-level cache.
constexpr Index block = 1024;
// Blocks after which a harmonic starts from its phase anew.
constexpr Index restart = 8;
// A harmonic is advanced this many points at a time, each by its own recurrence.
constexpr std::size_t lanes = 32;
constexpr std::size_t doublings = 5;
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

// Re[amplitude e^(i k x)], advanced along the grid by the recurrence d += -4 sin²(θ/2) z, z += d of θ = `lanes` k Δx,
// whose error grows with the number of steps only, however small the angle θ is.
struct Harmonic {
  alignas(line) std::array<double, lanes> z;  // at the next `lanes` points
  alignas(line) std::array<double, lanes> d;  // what they are above those `lanes` points before
  double rate;                                // 4 sin²(θ/2)
  Complex amplitude;                          // at x = 0
  Complex backward;                           // 1 - e^(-i θ), to full relative accuracy
  std::array<Complex, doublings> rotations;   // e^(i k Δx), e^(2 i k Δx), ..., e^(lanes/2 i k Δx)
  Turns step;                                 // k Δx

  Harmonic(Complex amplitude_at_zero, Turns turns_per_point) : amplitude(amplitude_at_zero), step(turns_per_point) {
    for (std::size_t w = 0; w < rotations.size(); ++w) {
      rotations[w] = unit(step << w);
    }
    const double half_angle = 0.5 * radians(step * static_cast<Turns>(lanes));
    backward = Complex(0.0, 2.0 * std::sin(half_angle)) * std::polar(1.0, -half_angle);
    rate = 4.0 * std::sin(half_angle) * std::sin(half_angle);
  }

  // From its phase at a point: the first `lanes` points by doubling, a run of points, then the same run rotated.
  STICTION_MULTIVERSION void start(Index point) {
    std::array<double, lanes> imaginary;
    const Complex first = amplitude * unit(step * static_cast<Turns>(point));
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

// The harmonics of one frequency n, and Σ_m cos φ_mn over those that are kept.
struct Group {
  std::vector<Harmonic> harmonics;
  double constant = 0.0;
};

// Directions m and M - m have opposite wave numbers: cos(-k x + φ') = cos(k x - φ'), so they make one harmonic of
// amplitude e^(i φ) + e^(-i φ'). m = M/2 has none and cancels; m = M has no partner.
std::vector<Group> groups(MatrixView phases, const HarmonicGrid& grid) {
  const long double most_turns = std::ldexp(1.0L, resolved_turns);
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
            "harmonic_profiles: gamma^(frequencies - 1) extent / length_scale is above 2^" +
            std::to_string(resolved_turns) +
            ", so the phases of the highest frequencies cannot be resolved; take a smaller gamma, fewer frequencies or "
            "a band limit");
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

// Subtracts the next block of `count` harmonics from the values: each value is loaded and stored once for all of them.
// So many lanes go through the block at a time as registers hold z and d of.
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

// G_n over the block that begins at a point; blocks come in order.
void next_block(Group& group, Index first, double* values) {
  fill_block(values, group.constant);
  if (first % (restart * block) == 0) {
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

// sums(row, j) = Σ_n weights(row, n) values[n][j] for `rows` rows and j < block: a tile of sums stays in registers
// while the groups pass by, each product in the order of n whatever the tile.
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

// Ten rows to a tile where there are as many: each value is then read a tenth as often as it is used.
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

// All rows of one whole block; `sums` points at its first column. Calls after(begin, end) when the rows from begin to
// end, excluded, are done and still in the cache.
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
      const Index row = std::min(done, rows - 4);  // the last tile may do some rows again
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

// ---- Over an area --------------------------------------------------------------------------------------------------

// Points along an axis that are computed from the phase of their first.
constexpr Index run = 64;
static_assert(block % run == 0);

// cos and sin of so many turns a point at `size` points from the first on; by angle addition, one rotation from each
// run's first point, so that errors do not grow.
STICTION_MULTIVERSION
void rotate(const double* table_cos, const double* table_sin, double c, double s, double* cosines, double* sines) {
  for (Index l = 0; l < run; ++l) {
    cosines[l] = c * table_cos[l] - s * table_sin[l];
    sines[l] = c * table_sin[l] + s * table_cos[l];
  }
}

struct Rotations {
  std::array<double, run> cosines;
  std::array<double, run> sines;
  Turns step;

  explicit Rotations(Turns turns_per_point) : step(turns_per_point) {
    for (std::size_t l = 0; l < run; ++l) {
      const Complex at = unit(step * static_cast<Turns>(l));
      cosines[l] = at.real();
      sines[l] = at.imag();
    }
  }

  // One run of points.
  void fill(Index first, double* cosine, double* sine) const {
    const Complex at = unit(step * static_cast<Turns>(first));
    rotate(cosines.data(), sines.data(), at.real(), at.imag(), cosine, sine);
  }
};

// Directions m and M - m have opposite wave numbers along x and equal ones along y. Together they are
// -w Re[even e^(i Y)] cos X + w Im[odd e^(i Y)] sin X with even, odd = e^(i φ) ± e^(i φ'); alone, both are e^(i φ).
struct ArealHarmonic {
  Complex even;
  Complex odd;
  Rotations along_y;
  Rotations along_x;
};

// What both directions of a frequency have in common, in turns a point.
struct Wave {
  long double y;
  long double x;
};

Wave wave(const HarmonicArea& area, Index m, Index directions, Index n) {
  const long double number = std::pow(static_cast<long double>(area.gamma), static_cast<long double>(n)) /
                             static_cast<long double>(area.length_scale);
  const long double angle =
      std::numbers::pi_v<long double> * static_cast<long double>(m) / static_cast<long double>(directions);
  return {number * std::sin(angle) * static_cast<long double>(area.spacing_y),
          number * std::cos(angle) * static_cast<long double>(area.spacing_x)};
}

// The harmonics that are kept, each with its weight in its amplitudes, and Σ w cos φ over them.
struct ArealSum {
  std::vector<ArealHarmonic> harmonics;
  double constant = 0.0;
};

ArealSum areal_sum(MatrixView phases, Values weights, const HarmonicArea& area, Index rows, Index columns) {
  const long double most_turns = std::ldexp(1.0L, resolved_turns);
  ArealSum sum;
  const Index directions = phases.rows();
  for (Index n = 0; n < phases.cols(); ++n) {
    const double weight = weights[static_cast<std::size_t>(n)];
    for (Index m = 1; m <= directions; ++m) {
      const Index partner = directions - m;
      if (partner > 0 && partner < m) {
        continue;
      }
      const Wave turns = wave(area, m, directions, n);
      if (area.band_limited && (std::abs(turns.y) > 0.5L || std::abs(turns.x) > 0.5L)) {
        continue;
      }
      if (std::max(std::abs(turns.y) * static_cast<long double>(rows),
                   std::abs(turns.x) * static_cast<long double>(columns)) > most_turns) {
        throw std::invalid_argument(
            "gamma^(frequencies - 1) extent / length_scale is above 2^" + std::to_string(resolved_turns) +
            ", so the phases of the highest frequencies cannot be resolved; take a smaller gamma, fewer frequencies, a "
            "smaller extent or a band limit");
      }
      const Complex one = std::polar(weight, phases(m - 1, n));
      const bool alone = partner == 0 || partner == m;
      const Complex other = alone ? Complex(0.0, 0.0) : std::polar(weight, phases(partner - 1, n));
      sum.harmonics.push_back({one + other, one - other, Rotations(turns_of(turns.y)), Rotations(turns_of(turns.x))});
      sum.constant += (one + other).real();
    }
  }
  return sum;
}

void require(bool condition, const char* what) {
  if (!condition) {
    throw std::invalid_argument(std::string("harmonics: ") + what);
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

std::vector<Level> harmonic_profiles(MatrixView phases, MatrixView weights, const HarmonicGrid& grid,
                                     Eigen::Ref<Matrix> profiles, const Checkpoint& checkpoint) {
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
  std::vector<Group> all = groups(phases, grid);
  const auto packed = aligned(static_cast<std::size_t>(weights.size()));
  Eigen::Map<Matrix>(packed.get(), weights.rows(), weights.cols()) = weights;
  const Eigen::Map<const Matrix> packed_weights(packed.get(), weights.rows(), weights.cols());
  const auto values = aligned(all.size() * block);
  std::vector<Levelling> levellings(static_cast<std::size_t>(weights.rows()));
  for (Index first = 0; first < grid.points; first += block) {
    for (std::size_t n = 0; n < all.size(); ++n) {
      checkpoint();
      next_block(all[n], first, values.get() + n * block);
    }
    const Index count = std::min(grid.points - first, block);
    const auto measure = [&](Index begin, Index end) {
      for (Index row = begin; row < end; ++row) {
        const double* heights = profiles.row(row).data() + first;
        levellings[static_cast<std::size_t>(row)].add({heights, static_cast<std::size_t>(count)});
      }
    };
    if (count == block) {
      product(packed_weights, values.get(), profiles.data() + first, profiles.outerStride(), measure);
    } else {
      const auto kept = aligned(static_cast<std::size_t>(weights.rows() * block));
      const Eigen::Map<Matrix> last_block(kept.get(), weights.rows(), block);
      product(packed_weights, values.get(), kept.get(), block, [](Index, Index) {});
      profiles.rightCols(count) = last_block.leftCols(count);
      measure(0, weights.rows());
    }
  }
  std::vector<Level> levels;
  levels.reserve(levellings.size());
  for (const Levelling& levelling : levellings) {
    levels.push_back(levelling.level());
  }
  return levels;
}

void harmonic_surface(MatrixView phases, Values weights, const HarmonicArea& area, Eigen::Ref<Matrix> heights,
                      const Checkpoint& checkpoint) {
  const Index rows = heights.rows();
  const Index columns = heights.cols();
  require(phases.rows() > 0 && phases.cols() > 0, "phases must have at least one direction and one frequency");
  require(static_cast<Index>(weights.size()) == phases.cols(), "weights must be one for each frequency of the phases");
  require(phases.allFinite(), "phases must be finite");
  require(
      area.spacing_y > 0.0 && std::isfinite(area.spacing_y) && area.spacing_x > 0.0 && std::isfinite(area.spacing_x),
      "spacings must be above 0 and finite");
  require(area.length_scale > 0.0 && std::isfinite(area.length_scale), "length_scale must be above 0 and finite");
  require(area.gamma > 1.0 && std::isfinite(area.gamma), "gamma must be above 1 and finite");

  const ArealSum sum = areal_sum(phases, weights, area, rows, columns);
  heights.setConstant(sum.constant);
  // A tile of rows and columns at a time, and of it so many harmonics that their factors stay in the cache.
  constexpr std::size_t together = 32;
  const auto of_x = aligned(2 * together * block);
  std::array<double, run> cosines;
  std::array<double, run> sines;
  const auto of_tile = aligned(run * block);
  const Eigen::Map<const Matrix> tile(of_tile.get(), run, block);
  const auto factors = aligned(run * 2 * together);
  for (Index column = 0; column < columns; column += block) {
    const Index width = std::min(block, columns - column);
    for (std::size_t begin = 0; begin < sum.harmonics.size(); begin += together) {
      const std::size_t count = std::min(together, sum.harmonics.size() - begin);
      for (std::size_t h = 0; h < count; ++h) {
        double* values = of_x.get() + 2 * h * block;
        for (Index j = 0; j < width; j += run) {
          sum.harmonics[begin + h].along_x.fill(column + j, values + j, values + block + j);
        }
      }
      Eigen::Map<Matrix> of_y(factors.get(), run, static_cast<Index>(2 * count));
      for (Index row = 0; row < rows; row += run) {
        checkpoint();
        for (std::size_t h = 0; h < count; ++h) {
          const ArealHarmonic& harmonic = sum.harmonics[begin + h];
          harmonic.along_y.fill(row, cosines.data(), sines.data());
          for (std::size_t i = 0; i < run; ++i) {
            const auto at = static_cast<Index>(i);
            of_y(at, static_cast<Index>(2 * h)) =
                -(harmonic.even.real() * cosines[i] - harmonic.even.imag() * sines[i]);
            of_y(at, static_cast<Index>(2 * h + 1)) = harmonic.odd.real() * sines[i] + harmonic.odd.imag() * cosines[i];
          }
        }
        product({of_y.data(), of_y.rows(), of_y.cols()}, of_x.get(), of_tile.get(), block, [](Index, Index) {});
        const Index height = std::min(run, rows - row);
        heights.block(row, column, height, width) += tile.topLeftCorner(height, width);
      }
    }
  }
}

}  // namespace stiction
