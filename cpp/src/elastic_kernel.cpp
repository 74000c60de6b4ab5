#include "stiction/elastic_kernel.hpp"

#include "fftw.hpp"
#include "multiversion.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstring>
#include <map>
#include <mutex>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

namespace stiction {
namespace {

using std::numbers::pi;

// Number of columns per block: a cache line contains 8 complex numbers in single precision.
constexpr std::size_t columns_per_block = 8;
constexpr std::size_t prefetch_distance_in_rows = 16;
// Areas with fewer values are computed in a single task, because several threads would wait for each other.
constexpr std::size_t values_per_task = std::size_t{1} << 15;
// Sum of all nine stencil weights, divided by the central weight. Wide contact patches require a small sum.
constexpr double stencil_sum = 0.04;
// Lower limit of the compliance at each wavenumber, divided by the compliance of a single loaded cell.
// Without this limit of the compliance, zero padding could make the compliance negative at some wavenumbers.
constexpr double min_compliance_ratio = 1e-3;
constexpr std::size_t stencil_points = 32;

// Successive rows are an odd number of cache lines apart, so that the elements of a column use all sets of the cache.
template <class Real>
std::size_t padded_stride(std::size_t count) {
  constexpr std::size_t numbers_per_line = alignment / sizeof(std::complex<Real>);
  return ((count + numbers_per_line - 1) / numbers_per_line | 1) * numbers_per_line;
}

// `points` real numbers form m = points/2 complex numbers with the Fourier coefficients z(k). Let θ = πk/m.
// Filtering with the factors h(k), where h(-k) = h(k), changes the coefficients z(k) to
//     y(k) = (a - b sin θ) z(k) + i b cos θ conj(z(m - k)),  a = (h(k) + h(m - k))/2,  b = (h(k) - h(m - k))/2.
//
// The second term of y(k) swaps the real and the imaginary part of z(m - k), because i conj(x + iy) = y + ix.
STICTION_MULTIVERSION
void multiply_line(const float* coefficients, const float* direct_factors, const float* mirrored_factors,
                   std::size_t size, float* __restrict result) {
  for (std::size_t i = 0; i < 2; ++i) {
    result[i] = direct_factors[i] * coefficients[i] + mirrored_factors[i] * coefficients[1 - i];
  }
  for (std::size_t i = 2; i < size; ++i) {
    result[i] = direct_factors[i] * coefficients[i] + mirrored_factors[i] * coefficients[size + 1 - i];
  }
}

STICTION_MULTIVERSION
void multiply_line(const double* coefficients, const double* direct_factors, const double* mirrored_factors,
                   std::size_t size, double* __restrict result) {
  for (std::size_t i = 0; i < 2; ++i) {
    result[i] = direct_factors[i] * coefficients[i] + mirrored_factors[i] * coefficients[1 - i];
  }
  for (std::size_t i = 2; i < size; ++i) {
    result[i] = direct_factors[i] * coefficients[i] + mirrored_factors[i] * coefficients[size + 1 - i];
  }
}

// The column `second` is read backwards along y, because its wavenumbers are opposite to those of column `first`.
template <class Real>
STICTION_INLINE void multiply_mirrored(Real* __restrict first, Real* __restrict second, const Real* first_factors,
                                       const Real* second_factors, const Real* mixing_factors, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) {
    const Real direct = first[i];
    const Real mirrored = *(second - i);
    first[i] = first_factors[i] * direct + mixing_factors[i] * mirrored;
    *(second - i) = second_factors[i] * mirrored + mixing_factors[i] * direct;
  }
}

constexpr std::size_t wavenumbers_per_block = 64;

// `factors` has one element per wavenumber i <= size / 2 along y: coefficients i and size - i have equal factors.
// Coefficient i of column k is combined with coefficient size - i of column m - k. `sine` is sin(πk/m).
template <class Real>
STICTION_INLINE void mix_columns_kernel(Real* __restrict first, Real* __restrict second, const Real* factors,
                                        const Real* mirrored_factors, Real sine, Real cosine, std::size_t size) {
  std::array<Real, 2 * wavenumbers_per_block> first_factors;
  std::array<Real, 2 * wavenumbers_per_block> second_factors;
  std::array<Real, 2 * wavenumbers_per_block> mixing_factors;
  for (std::size_t from = 0; 2 * from <= size; from += wavenumbers_per_block) {
    const std::size_t count = std::min(wavenumbers_per_block, size / 2 + 1 - from);
    for (std::size_t i = 0; i < count; ++i) {
      const Real mean = Real{0.5} * (factors[from + i] + mirrored_factors[from + i]);
      const Real difference = Real{0.5} * (factors[from + i] - mirrored_factors[from + i]);
      first_factors[2 * i] = first_factors[2 * i + 1] = mean - difference * sine;
      second_factors[2 * i] = second_factors[2 * i + 1] = mean + difference * sine;
      mixing_factors[2 * i] = mixing_factors[2 * i + 1] = difference * cosine;
    }
    std::size_t skip = 0;
    if (from == 0) {
      multiply_mirrored(first, second + 1, first_factors.data(), second_factors.data(), mixing_factors.data(), 2);
      skip = 1;
    }
    // If `size` is even, coefficient size / 2 is its own mirror image, and must not be multiplied twice.
    const std::size_t mirrored_count = size % 2 == 0 && from + count == size / 2 + 1 ? count - 1 : count;
    if (count > skip) {
      multiply_mirrored(first + 2 * (from + skip), second + 2 * (size - from - skip) + 1, &first_factors[2 * skip],
                        &second_factors[2 * skip], &mixing_factors[2 * skip], 2 * (count - skip));
    }
    if (mirrored_count > skip) {
      multiply_mirrored(second + 2 * (from + skip), first + 2 * (size - from - skip) + 1, &second_factors[2 * skip],
                        &first_factors[2 * skip], &mixing_factors[2 * skip], 2 * (mirrored_count - skip));
    }
  }
}

STICTION_MULTIVERSION
void mix_columns(float* first, float* second, const float* factors, const float* mirrored_factors, float sine,
                 float cosine, std::size_t size) {
  mix_columns_kernel(first, second, factors, mirrored_factors, sine, cosine, size);
}

STICTION_MULTIVERSION
void mix_columns(double* first, double* second, const double* factors, const double* mirrored_factors, double sine,
                 double cosine, std::size_t size) {
  mix_columns_kernel(first, second, factors, mirrored_factors, sine, cosine, size);
}

// The processor does not prefetch columns by itself, because successive rows are far apart in memory.
template <class Real>
void prefetch_columns(const std::complex<Real>* columns) {
  for (std::size_t column = 0; column < columns_per_block; column += alignment / sizeof(std::complex<Real>)) {
    __builtin_prefetch(columns + column);
  }
}

template <class Real>
void gather_columns(const std::complex<Real>* area, std::size_t stride, std::span<const std::size_t> rows,
                    std::size_t count, std::size_t column_stride, std::complex<Real>* columns) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    prefetch_columns(area + rows[std::min(i + prefetch_distance_in_rows, rows.size() - 1)] * stride);
    const std::complex<Real>* from = area + rows[i] * stride;
    for (std::size_t column = 0; column < count; ++column) {
      columns[column * column_stride + rows[i]] = from[column];
    }
  }
}

template <class Real>
void scatter_columns(const std::complex<Real>* columns, std::size_t column_stride, std::span<const std::size_t> rows,
                     std::size_t count, std::size_t stride, std::complex<Real>* area) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    prefetch_columns(area + rows[std::min(i + prefetch_distance_in_rows, rows.size() - 1)] * stride);
    std::complex<Real>* to = area + rows[i] * stride;
    for (std::size_t column = 0; column < count; ++column) {
      to[column] = columns[column * column_stride + rows[i]];
    }
  }
}

struct TransformShape {
  std::size_t rows;
  std::size_t columns;
  std::size_t padded_rows;
  std::size_t padded_columns;

  bool packed() const { return padded_columns % 2 == 0; }
  std::size_t coefficient_count() const { return packed() ? padded_columns / 2 : padded_columns; }
  // Opposite wavenumbers have equal factors, so factors are stored only for wavenumbers >= 0.
  std::size_t factors_along_x() const { return padded_columns / 2 + 1; }
  std::size_t factors_along_y() const { return padded_rows / 2 + 1; }
};

struct FftPlans {
  std::vector<std::pair<std::size_t, std::shared_ptr<const ComplexFft<float>>>> single_plans;
  std::vector<std::pair<std::size_t, std::shared_ptr<const ComplexFft<double>>>> double_plans;

  template <class Real>
  std::shared_ptr<const ComplexFft<Real>> get(std::size_t points) {
    auto& plans = [&]() -> auto& {
      if constexpr (std::is_same_v<Real, float>) {
        return single_plans;
      } else {
        return double_plans;
      }
    }();
    for (const auto& [size, plan] : plans) {
      if (size == points) {
        return plan;
      }
    }
    return plans.emplace_back(points, std::make_shared<const ComplexFft<Real>>(points)).second;
  }
};

struct Scratch {
  AlignedBuffer coefficients;
  std::vector<std::array<AlignedBuffer, 5>> threads;
};

// Filter with equal factors for k and -k. Factors are stored with the wavenumber along y varying fastest.
template <class Real>
class Filter {
 public:
  template <class Factors>
  Filter(const TransformShape& shape, Factors&& factors, FftPlans& plans)
      : shape_(shape), along_x_(plans.get<Real>(shape.coefficient_count())) {
    const double norm = 1.0 / (static_cast<double>(shape.coefficient_count()) * static_cast<double>(shape.padded_rows));
    if (shape.rows > 1 || shape.padded_rows > 1) {
      along_y_ = plans.get<Real>(shape.padded_rows);
      if constexpr (std::is_same_v<Real, std::decay_t<typename std::decay_t<Factors>::value_type>>) {
        factors_ = std::forward<Factors>(factors);
      } else {
        factors_.assign(factors.begin(), factors.end());
      }
      for (Real& factor : factors_) {
        factor *= static_cast<Real>(norm);
      }
      return;
    }
    const std::size_t count = shape.coefficient_count();
    direct_.resize(2 * count);
    mirrored_.resize(2 * count);
    for (std::size_t k = 0; k < count; ++k) {
      double direct = norm * factors[shape.packed() || k <= count / 2 ? k : count - k];
      double mirrored = 0.0;
      if (shape.packed()) {
        const double opposite = norm * factors[count - k];
        const double angle = pi * static_cast<double>(k) / static_cast<double>(count);
        const double difference = 0.5 * (direct - opposite);
        direct = 0.5 * (direct + opposite) - difference * std::sin(angle);
        mirrored = difference * std::cos(angle);
      }
      direct_[2 * k] = direct_[2 * k + 1] = static_cast<Real>(direct);
      mirrored_[2 * k] = mirrored_[2 * k + 1] = static_cast<Real>(mirrored);
    }
  }

  void operator()(std::span<const Real> values, std::span<Real> result, Scratch& scratch, const ThreadPool& pool,
                  std::span<const std::size_t> result_rows = {}) const {
    if (values.size() != shape_.rows * shape_.columns || result.size() != values.size()) {
      throw std::invalid_argument("ElasticKernel: values must have as many elements as the grid has points");
    }
    scratch.threads.resize(std::max(scratch.threads.size(), pool.threads()));
    if (along_y_) {
      filter_area(values, result, scratch, pool, result_rows);
    } else {
      filter_line(values, result, scratch.threads[0]);
      pool.check_cancellation();
    }
  }

 private:
  using Complex = std::complex<Real>;

  static Real* as_reals(Complex* coefficients) { return reinterpret_cast<Real*>(coefficients); }

  void pack(const Real* values, Complex* packed) const {
    Real* to = as_reals(packed);
    if (shape_.packed()) {
      std::copy_n(values, shape_.columns, to);
      std::fill(to + shape_.columns, to + shape_.padded_columns, Real{0});
      return;
    }
    for (std::size_t i = 0; i < shape_.columns; ++i) {
      packed[i] = values[i];
    }
  }

  void unpack(Complex* packed, Real* values) const {
    const Real* from = as_reals(packed);
    if (shape_.packed()) {
      std::copy_n(from, shape_.columns, values);
      return;
    }
    for (std::size_t i = 0; i < shape_.columns; ++i) {
      values[i] = from[2 * i];
    }
  }

  void filter_line(std::span<const Real> values, std::span<Real> result, std::array<AlignedBuffer, 5>& buffers) const {
    const std::size_t count = shape_.coefficient_count();
    Complex* packed = buffers[0].template get<Real>(count);
    Complex* coefficients = buffers[1].template get<Real>(count);
    pack(values.data(), packed);
    along_x_->forward(packed, coefficients);
    multiply_line(as_reals(coefficients), direct_.data(), mirrored_.data(), 2 * count, as_reals(packed));
    along_x_->inverse(packed, coefficients);
    unpack(coefficients, result.data());
  }

  void filter_area(std::span<const Real> values, std::span<Real> result, Scratch& scratch, const ThreadPool& pool,
                   std::span<const std::size_t> result_rows) const {
    const std::size_t count = shape_.coefficient_count();
    const std::size_t stride = padded_stride<Real>(count);
    Complex* area = scratch.coefficients.get<Real>(shape_.rows * stride);
    // If the contact area is small, many rows contain only zeros, which need no transform along x.
    std::vector<std::size_t> filled;
    for (std::size_t row = 0; row < shape_.rows; ++row) {
      const auto* from = values.data() + row * shape_.columns;
      if (std::any_of(from, from + shape_.columns, [](Real value) { return value != Real{0}; })) {
        filled.push_back(row);
      }
    }
    const std::size_t rows_per_task = std::max<std::size_t>(values_per_task / count, 1);
    pool.run((filled.size() + rows_per_task - 1) / rows_per_task, [&](std::size_t task, std::size_t thread) {
      Complex* packed = scratch.threads[thread][0].template get<Real>(count);
      for (std::size_t i = task * rows_per_task; i < std::min((task + 1) * rows_per_task, filled.size()); ++i) {
        pack(values.data() + filled[i] * shape_.columns, packed);
        along_x_->forward(packed, area + filled[i] * stride);
      }
    });
    std::vector<std::size_t> all_rows;
    if (result_rows.empty()) {
      all_rows.resize(shape_.rows);
      std::iota(all_rows.begin(), all_rows.end(), std::size_t{0});
      result_rows = all_rows;
    }
    // Columns k and m - k are filtered together. Column 0 and, if m is even, column m/2 are filtered alone.
    const std::size_t pairs = shape_.packed() ? count / 2 + 1 : count;
    const std::size_t blocks = std::max<std::size_t>(values_per_task / shape_.padded_rows / columns_per_block, 1);
    const std::size_t columns_per_task = blocks * columns_per_block;
    pool.run((pairs + columns_per_task - 1) / columns_per_task, [&](std::size_t task, std::size_t thread) {
      const std::size_t last = std::min((task + 1) * columns_per_task, pairs);
      for (std::size_t first = task * columns_per_task; first < last; first += columns_per_block) {
        filter_columns(area, stride, filled, result_rows, first, std::min(first + columns_per_block, last),
                       scratch.threads[thread]);
      }
    });
    pool.run((result_rows.size() + rows_per_task - 1) / rows_per_task, [&](std::size_t task, std::size_t thread) {
      Complex* packed = scratch.threads[thread][0].template get<Real>(count);
      for (std::size_t i = task * rows_per_task; i < std::min((task + 1) * rows_per_task, result_rows.size()); ++i) {
        along_x_->inverse(area + result_rows[i] * stride, packed);
        unpack(packed, result.data() + result_rows[i] * shape_.columns);
      }
    });
  }

  void filter_columns(Complex* area, std::size_t stride, std::span<const std::size_t> filled,
                      std::span<const std::size_t> result_rows, std::size_t first, std::size_t last,
                      std::array<AlignedBuffer, 5>& buffers) const {
    const std::size_t size = shape_.padded_rows;
    const std::size_t column_stride = padded_stride<Real>(size);
    const std::size_t count = shape_.coefficient_count();
    const std::size_t column_count = last - first;
    Complex* values = buffers[1].template get<Real>(columns_per_block * column_stride);
    std::array<Complex*, 2> coefficients = {buffers[2].template get<Real>(columns_per_block * column_stride),
                                            buffers[3].template get<Real>(columns_per_block * column_stride)};
    const std::size_t begin = std::max<std::size_t>(first, 1);
    const std::size_t end = 2 * (last - 1) == count ? last - 1 : last;
    const std::size_t mirrored_count = shape_.packed() && end > begin ? end - begin : 0;
    // Column k has the mirrored column count - k. Mirrored columns run from count - end + 1 to count - begin.
    const std::array<std::pair<std::size_t, std::size_t>, 2> blocks = {
        {{first, column_count}, {count - end + 1, mirrored_count}}};
    for (std::size_t block = 0; block < 2; ++block) {
      const auto [from, width] = blocks[block];
      if (width == 0) {
        continue;
      }
      if (filled.size() < size) {
        std::fill_n(values, width * column_stride, Complex{});
      }
      gather_columns(area + from, stride, filled, width, column_stride, values);
      for (std::size_t column = 0; column < width; ++column) {
        along_y_->forward(values + column * column_stride, coefficients[block] + column * column_stride);
      }
    }
    for (std::size_t k = first; k < last; ++k) {
      Complex* column = coefficients[0] + (k - first) * column_stride;
      if (!shape_.packed()) {
        scale_column(column, k <= count / 2 ? k : count - k);
      } else if (k >= begin && k < end) {
        mix_pair(column, coefficients[1] + (end - 1 - k) * column_stride, k);
      } else {
        std::copy_n(column, size, values);
        mix_pair(column, values, k);
      }
    }
    for (std::size_t block = 0; block < 2; ++block) {
      const auto [from, width] = blocks[block];
      for (std::size_t column = 0; column < width; ++column) {
        along_y_->inverse(coefficients[block] + column * column_stride, values + column * column_stride);
      }
      scatter_columns(values, column_stride, result_rows, width, stride, area + from);
    }
  }

  void scale_column(Complex* coefficients, std::size_t k) const {
    const std::size_t size = shape_.padded_rows;
    const Real* factors = factors_.data() + k * shape_.factors_along_y();
    for (std::size_t i = 0; i < size; ++i) {
      coefficients[i] *= factors[std::min(i, size - i)];
    }
  }

  void mix_pair(Complex* first, Complex* second, std::size_t k) const {
    const std::size_t count = shape_.coefficient_count();
    const Real* factors = factors_.data() + k * shape_.factors_along_y();
    const Real* mirrored_factors = factors_.data() + (count - k) * shape_.factors_along_y();
    const double angle = pi * static_cast<double>(k) / static_cast<double>(count);
    mix_columns(as_reals(first), as_reals(second), factors, mirrored_factors, static_cast<Real>(std::sin(angle)),
                static_cast<Real>(std::cos(angle)), shape_.padded_rows);
  }

  TransformShape shape_;
  std::shared_ptr<const ComplexFft<Real>> along_x_;
  std::shared_ptr<const ComplexFft<Real>> along_y_;  // empty for lines
  std::vector<Real> factors_;                        // factors of areas
  std::vector<Real> direct_;                         // factors of lines
  std::vector<Real> mirrored_;
};

// In-place Fourier transform of an even sequence of 2m real numbers, given by its first m + 1 numbers.
class EvenFft {
 public:
  EvenFft(std::size_t half, FftPlans& plans) : half_(half), fft_(plans.get<double>(half)), twiddles_(half + 1) {
    for (std::size_t k = 0; k <= half; ++k) {
      twiddles_[k] = std::polar(1.0, -pi * static_cast<double>(k) / static_cast<double>(half));
    }
  }

  void operator()(double* values, std::array<AlignedBuffer, 5>& buffers) const {
    std::complex<double>* packed = buffers[0].get<double>(half_);
    std::complex<double>* coefficients = buffers[1].get<double>(half_);
    const auto at = [&](std::size_t i) { return values[i <= half_ ? i : 2 * half_ - i]; };
    for (std::size_t i = 0; i < half_; ++i) {
      packed[i] = {at(2 * i), at(2 * i + 1)};
    }
    fft_->forward(packed, coefficients);
    for (std::size_t k = 0; k <= half_; ++k) {
      const bool ends = k == 0 || k == half_;
      const std::complex<double> direct = coefficients[ends ? 0 : k];
      const std::complex<double> mirrored = std::conj(coefficients[ends ? 0 : half_ - k]);
      values[k] =
          0.5 * ((direct + mirrored) - std::complex<double>(0.0, 1.0) * twiddles_[k] * (direct - mirrored)).real();
    }
  }

 private:
  std::size_t half_;
  std::shared_ptr<const ComplexFft<double>> fft_;
  std::vector<std::complex<double>> twiddles_;
};

std::size_t padded_length(std::size_t points) { return 2 * fast_length(points); }

std::vector<double> stiffness(const TransformShape& shape, const Grid& grid, double effective_modulus) {
  std::vector<double> factors;
  factors.reserve(shape.factors_along_x() * shape.factors_along_y());
  const double step_x = 2 * pi / (static_cast<double>(shape.padded_columns) * grid.spacing_x);
  const double step_y = 2 * pi / (static_cast<double>(shape.padded_rows) * grid.spacing_y);
  for (std::size_t i = 0; i < shape.factors_along_x(); ++i) {
    for (std::size_t j = 0; j < shape.factors_along_y(); ++j) {
      const double x = step_x * static_cast<double>(i);
      const double y = step_y * static_cast<double>(j);
      factors.push_back(0.5 * effective_modulus * std::sqrt(x * x + y * y));
    }
  }
  return factors;
}

// Displacement [µm] of the origin due to 1 GPa on the segment (0, x) of a line, or on the rectangle (0, x) by (0, y).
double corner_integral(double x, double effective_modulus) {
  // The result is the integral of -2/(π E*) ln|x|. Another unit of x would shift all displacements by the same amount.
  return -2 / (pi * effective_modulus) * x * (std::log(std::abs(x)) - 1.0);
}

double corner_integral(double x, double y, double effective_modulus) {
  return (x * std::asinh(y / std::abs(x)) + y * std::asinh(x / std::abs(y))) / (pi * effective_modulus);
}

double cell_edge(std::size_t i, double spacing) { return (static_cast<double>(i) - 0.5) * spacing; }

// Compute displacements of the cells in one row due to 1 GPa on a cell `row` rows away. On a line, `row` is 0.
void compute_influence_row(const Grid& grid, double effective_modulus, std::size_t row, std::span<double> influence) {
  const std::size_t count = influence.size();
  const auto corner = [&](std::size_t i, std::size_t j) {
    const double x = cell_edge(j, grid.spacing_x);
    return grid.line ? corner_integral(x, effective_modulus)
                     : corner_integral(x, cell_edge(i, grid.spacing_y), effective_modulus);
  };
  const auto along = [&](std::size_t j) { return grid.line ? corner(0, j) : corner(row + 1, j) - corner(row, j); };
  double before = along(0);
  for (std::size_t j = 0; j < count; ++j) {
    const double after = along(j + 1);
    influence[j] = after - before;
    before = after;
  }
}

TransformShape transform_shape(const Grid& grid) {
  if (grid.periodic) {
    return {grid.rows, grid.columns, grid.rows, grid.columns};
  }
  return {grid.rows, grid.columns, grid.line ? 1 : padded_length(grid.rows), padded_length(grid.columns)};
}

std::vector<double> compliance(const TransformShape& shape, const Grid& grid, double effective_modulus, FftPlans& plans,
                               Scratch& scratch, const ThreadPool& pool) {
  if (grid.periodic) {
    std::vector<double> factors = stiffness(shape, grid, effective_modulus);
    std::transform(factors.begin(), factors.end(), factors.begin(),
                   [](double factor) { return factor > 0.0 ? 1.0 / factor : 0.0; });
    return factors;
  }
  // Only one quadrant is transformed: the influence coefficients are symmetric, and the padded sizes are even.
  // Beyond the grid, the padding repeats the last influence coefficients. No result depends on the padding.
  const std::size_t width = shape.factors_along_x();
  const std::size_t height = shape.factors_along_y();
  std::vector<double> factors(width * height);
  const EvenFft along_x(width - 1, plans);
  scratch.threads.resize(std::max(scratch.threads.size(), pool.threads()));
  if (grid.line) {
    compute_influence_row(grid, effective_modulus, 0, {factors.data(), grid.columns});
    std::fill(factors.begin() + static_cast<std::ptrdiff_t>(grid.columns), factors.end(), factors[grid.columns - 1]);
    along_x(factors.data(), scratch.threads[0]);
    return factors;
  }
  const EvenFft along_y(height - 1, plans);
  std::vector<double> rows(std::min(grid.rows, height) * width);
  pool.run(grid.rows, [&](std::size_t row, std::size_t thread) {
    double* values = rows.data() + row * width;
    compute_influence_row(grid, effective_modulus, row, {values, grid.columns});
    std::fill(values + grid.columns, values + width, values[grid.columns - 1]);
    along_x(values, scratch.threads[thread]);
  });
  pool.run((width + columns_per_block - 1) / columns_per_block, [&](std::size_t task, std::size_t thread) {
    const std::size_t first = task * columns_per_block;
    const std::size_t last = std::min(first + columns_per_block, width);
    for (std::size_t row = 0; row < height; ++row) {
      const double* from = rows.data() + std::min(row, grid.rows - 1) * width;
      for (std::size_t column = first; column < last; ++column) {
        factors[column * height + row] = from[column];
      }
    }
    for (std::size_t column = first; column < last; ++column) {
      along_y(factors.data() + column * height, scratch.threads[thread]);
    }
  });
  return factors;
}

// The weights of the eight neighbours are Fourier sums of the stiffness over the wavenumbers of a small periodic area.
std::array<double, 9> compute_stencil(const Grid& grid, double effective_modulus) {
  Grid small = grid;
  small.rows = small.columns = stencil_points;
  const TransformShape shape = {stencil_points, stencil_points, stencil_points, stencil_points};
  const std::vector<double> factors = stiffness(shape, small, effective_modulus);
  const auto weight = [&](std::size_t down, std::size_t right) {
    double sum = 0.0;
    for (std::size_t i = 0; i < stencil_points; ++i) {
      for (std::size_t j = 0; j < stencil_points; ++j) {
        const double factor =
            factors[std::min(i, stencil_points - i) * shape.factors_along_y() + std::min(j, stencil_points - j)];
        sum += factor * std::cos(2 * pi * static_cast<double>(i * right) / stencil_points) *
               std::cos(2 * pi * static_cast<double>(j * down) / stencil_points);
      }
    }
    return std::min(sum / (stencil_points * stencil_points), 0.0);
  };
  std::array<double, 9> stencil{};
  double sum = 0.0;
  for (std::size_t i = 0; i < 9; ++i) {
    if (i != 4) {
      stencil[i] = weight(i / 3 == 1 ? 0 : 1, i % 3 == 1 ? 0 : 1);
      sum += stencil[i];
    }
  }
  stencil[4] = sum / (stencil_sum - 1);
  return stencil;
}

void check_grid(const char* name, const Grid& grid, double effective_modulus) {
  if (grid.size() == 0 || !(grid.spacing_x > 0.0) || !(grid.spacing_y > 0.0) || !(effective_modulus > 0.0) ||
      (grid.line && grid.rows != 1)) {
    throw std::invalid_argument(
        std::string(name) +
        ": the grid must not be empty, spacings and modulus must be above 0, and a line must have one row");
  }
}

// On a free grid, the returned compliance [µm/GPa] is positive at each wavenumber.
// The compliance at wavenumber 0 is arbitrary, because it only shifts all displacements by the same amount.
std::vector<double> invertible_compliance(const TransformShape& shape, const Grid& grid, double effective_modulus,
                                          FftPlans& plans, const ThreadPool& pool) {
  Scratch scratch;
  std::vector<double> factors = compliance(shape, grid, effective_modulus, plans, scratch, pool);
  if (grid.periodic) {
    return factors;
  }
  double own_displacement = 0.0;
  compute_influence_row(grid, effective_modulus, 0, {&own_displacement, 1});
  if (!(factors[0] > 0.0)) {
    factors[0] = std::abs(*std::max_element(
        factors.begin(), factors.end(), [](double left, double right) { return std::abs(left) < std::abs(right); }));
  }
  for (double& factor : factors) {
    factor = std::max(factor, min_compliance_ratio * own_displacement);
  }
  return factors;
}

std::vector<double> to_stiffness(std::vector<double> compliance_factors) {
  for (double& factor : compliance_factors) {
    factor = factor > 0.0 ? 1.0 / factor : 0.0;
  }
  return compliance_factors;
}

std::vector<double> to_preconditioner(std::vector<double> compliance_factors) {
  compliance_factors[0] = *std::max_element(compliance_factors.begin(), compliance_factors.end());
  return compliance_factors;
}

}  // namespace

std::size_t fast_length(std::size_t points) {
  for (std::size_t length = std::max<std::size_t>(points, 1);; ++length) {
    std::size_t remainder = length;
    for (const std::size_t factor : {2U, 3U, 5U}) {
      while (remainder % factor == 0) {
        remainder /= factor;
      }
    }
    if (remainder == 1) {
      return length;
    }
  }
}

struct Workspace::Buffers {
  Scratch scratch;
};

Workspace::Workspace() : buffers_(std::make_unique<Buffers>()) {}
Workspace::~Workspace() = default;

// Each filter is computed on its first use, because most calculations need only some of the filters.
struct ElasticKernel::Transforms {
  TransformShape shape;
  double effective_modulus;
  std::vector<double> compliance;
  std::mutex mutex;
  FftPlans plans;
  std::unique_ptr<const Filter<double>> double_displacement;
  std::unique_ptr<const Filter<float>> single_displacement;
  // Spectral filters, keyed by the stiffness of the elastic foundation [GPa/µm], which is 0 without a foundation.
  std::map<double, const Filter<float>> foundation_filters;

  const Filter<float>* foundation_filter(const Grid& grid, double foundation) {
    const std::lock_guard lock(mutex);
    if (const auto found = foundation_filters.find(foundation); found != foundation_filters.end()) {
      return &found->second;
    }
    const TransformShape unpadded = {grid.rows, grid.columns, grid.rows, grid.columns};
    std::vector<double> factors = stiffness(unpadded, grid, effective_modulus);
    if (foundation > 0.0) {
      std::transform(factors.begin(), factors.end(), factors.begin(),
                     [&](double factor) { return 1.0 / (factor + foundation); });
    }
    return &foundation_filters.emplace(foundation, Filter<float>(unpadded, factors, plans)).first->second;
  }
};

ElasticKernel::ElasticKernel(const Grid& grid, double effective_modulus, const ThreadPool& pool) : grid_(grid) {
  check_grid("ElasticKernel", grid, effective_modulus);
  if (!grid.line) {
    stencil_ = compute_stencil(grid, effective_modulus);
  }
  transforms_ = std::make_unique<Transforms>();
  transforms_->shape = transform_shape(grid);
  transforms_->effective_modulus = effective_modulus;
  Scratch scratch;
  transforms_->compliance = compliance(transforms_->shape, grid, effective_modulus, transforms_->plans, scratch, pool);
  transforms_->single_displacement =
      std::make_unique<const Filter<float>>(transforms_->shape, transforms_->compliance, transforms_->plans);
}

ElasticKernel::~ElasticKernel() = default;

void ElasticKernel::displacement(Values pressure, std::span<double> displacements, Workspace& workspace,
                                 const ThreadPool& pool, std::span<const std::size_t> rows) const {
  {
    const std::lock_guard lock(transforms_->mutex);
    if (!transforms_->double_displacement) {
      transforms_->double_displacement = std::make_unique<const Filter<double>>(
          transforms_->shape, std::move(transforms_->compliance), transforms_->plans);
      transforms_->compliance = {};
    }
  }
  (*transforms_->double_displacement)(pressure, displacements, workspace.buffers_->scratch, pool, rows);
}

void ElasticKernel::displacement(std::span<const float> pressure, std::span<float> displacements, Workspace& workspace,
                                 const ThreadPool& pool, std::span<const std::size_t> rows) const {
  (*transforms_->single_displacement)(pressure, displacements, workspace.buffers_->scratch, pool, rows);
}

void ElasticKernel::apply_stiffness(std::span<const float> values, std::span<float> result, Workspace& workspace,
                                    const ThreadPool& pool) const {
  (*transforms_->foundation_filter(grid_, 0.0))(values, result, workspace.buffers_->scratch, pool);
}

void ElasticKernel::apply_foundation_compliance(std::span<const float> loads, double foundation,
                                                std::span<float> result, Workspace& workspace,
                                                const ThreadPool& pool) const {
  if (!(foundation > 0.0)) {
    throw std::invalid_argument("ElasticKernel: foundation must be above 0");
  }
  (*transforms_->foundation_filter(grid_, foundation))(loads, result, workspace.buffers_->scratch, pool);
}

struct StiffnessKernel::Transforms {
  Transforms(const Grid& grid, double effective_modulus, const ThreadPool& pool) : Transforms(transform_shape(grid)) {
    const std::vector<double> factors =
        invertible_compliance(transform_shape(grid), grid, effective_modulus, plans, pool);
    double_pressure = std::make_unique<const Filter<double>>(shape, to_stiffness(factors), plans);
    single_pressure = std::make_unique<const Filter<float>>(shape, to_stiffness(factors), plans);
    double_displacement = std::make_unique<const Filter<double>>(shape, factors, plans);
    preconditioner = std::make_unique<const Filter<float>>(shape, to_preconditioner(factors), plans);
  }

  explicit Transforms(const TransformShape& padded)
      : shape{padded.padded_rows, padded.padded_columns, padded.padded_rows, padded.padded_columns} {}

  TransformShape shape;
  FftPlans plans;
  std::unique_ptr<const Filter<double>> double_pressure;
  std::unique_ptr<const Filter<float>> single_pressure;
  std::unique_ptr<const Filter<double>> double_displacement;
  std::unique_ptr<const Filter<float>> preconditioner;
};

StiffnessKernel::StiffnessKernel(const Grid& grid, double effective_modulus, const ThreadPool& pool) {
  check_grid("StiffnessKernel", grid, effective_modulus);
  transforms_ = std::make_unique<const Transforms>(grid, effective_modulus, pool);
}

StiffnessKernel::~StiffnessKernel() = default;

std::size_t StiffnessKernel::rows() const { return transforms_->shape.rows; }
std::size_t StiffnessKernel::columns() const { return transforms_->shape.columns; }

void StiffnessKernel::pressure(Values displacements, std::span<double> pressures, Workspace& workspace,
                               const ThreadPool& pool) const {
  (*transforms_->double_pressure)(displacements, pressures, workspace.buffers_->scratch, pool);
}

void StiffnessKernel::pressure(std::span<const float> displacements, std::span<float> pressures, Workspace& workspace,
                               const ThreadPool& pool) const {
  (*transforms_->single_pressure)(displacements, pressures, workspace.buffers_->scratch, pool);
}

void StiffnessKernel::displacement(Values pressures, std::span<double> displacements, Workspace& workspace,
                                   const ThreadPool& pool) const {
  (*transforms_->double_displacement)(pressures, displacements, workspace.buffers_->scratch, pool);
}

void StiffnessKernel::precondition(std::span<const float> pressures, std::span<float> displacements,
                                   Workspace& workspace, const ThreadPool& pool) const {
  (*transforms_->preconditioner)(pressures, displacements, workspace.buffers_->scratch, pool);
}

double uniform_pressure_deviation(const Grid& grid, double effective_modulus) {
  // The displacements are symmetric, so a quarter of the grid points is enough for their standard deviation.
  // The displacement of a grid point is the sum of four values of `corner_integral`, one for each corner of the grid.
  const auto displacement = [&](std::size_t row, std::size_t column) {
    double sum = 0.0;
    for (const std::size_t j : {column + 1, grid.columns - column}) {
      const double x = cell_edge(j, grid.spacing_x);
      if (grid.line) {
        sum += corner_integral(x, effective_modulus);
        continue;
      }
      for (const std::size_t i : {row + 1, grid.rows - row}) {
        sum += corner_integral(x, cell_edge(i, grid.spacing_y), effective_modulus);
      }
    }
    return sum;
  };
  const auto multiplicity = [](std::size_t i, std::size_t count) { return 2 * i + 1 == count ? 1.0 : 2.0; };
  const double shift = displacement(0, 0);
  double sum = 0.0;
  double squares = 0.0;
  for (std::size_t row = 0; 2 * row < grid.rows; ++row) {
    for (std::size_t column = 0; 2 * column < grid.columns; ++column) {
      const double deviation = displacement(row, column) - shift;
      const double weight = multiplicity(row, grid.rows) * multiplicity(column, grid.columns);
      sum += weight * deviation;
      squares += weight * deviation * deviation;
    }
  }
  const auto count = static_cast<double>(grid.size());
  return std::sqrt(std::max(squares / count - sum / count * (sum / count), 0.0));
}

}  // namespace stiction
