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
#include <stdexcept>
#include <utility>

namespace stiction {
namespace {

using std::numbers::pi;

// Columns of an area that are transformed at a time: a line of the cache in single precision.
constexpr std::size_t columns_at_once = 8;
// Numbers of rows or columns that are a thread's at a time, and that lie between two looks at the checkpoint. Fewer are
// not shared: threads would wait for each other.
constexpr std::size_t numbers_at_once = std::size_t{1} << 15;
// Sum of the stencil's weights over the one of the point itself: patches are many points wide.
constexpr double stencil_sum = 0.04;
// Points along an axis of the area from which the stencil is taken.
constexpr std::size_t stencil_points = 32;

// Rows of complex numbers begin at lines of the cache, an odd number of them apart: columns then fill all of it.
template <class Real>
std::size_t stride_of(std::size_t count) {
  constexpr std::size_t in_line = alignment / sizeof(std::complex<Real>);
  return ((count + in_line - 1) / in_line | 1) * in_line;
}

// Two real numbers are transformed as one complex number. With z the waves of so packed numbers, h even real factors,
// m half of the points and θ = πk/m, packed results have the waves
//
//     (a - b sin θ) z(k) + i b cos θ conj(z(m - k)),    a = (h(k) + h(m - k))/2,  b = (h(k) - h(m - k))/2,
//
// and i conj(x + iy) = y + ix, so that these are sums of real numbers forwards and backwards.
STICTION_MULTIVERSION
void multiply_line(const float* waves, const float* own, const float* other, std::size_t size,
                   float* __restrict result) {
  for (std::size_t i = 0; i < 2; ++i) {
    result[i] = own[i] * waves[i] + other[i] * waves[1 - i];
  }
  for (std::size_t i = 2; i < size; ++i) {
    result[i] = own[i] * waves[i] + other[i] * waves[size + 1 - i];
  }
}

STICTION_MULTIVERSION
void multiply_line(const double* waves, const double* own, const double* other, std::size_t size,
                   double* __restrict result) {
  for (std::size_t i = 0; i < 2; ++i) {
    result[i] = own[i] * waves[i] + other[i] * waves[1 - i];
  }
  for (std::size_t i = 2; i < size; ++i) {
    result[i] = own[i] * waves[i] + other[i] * waves[size + 1 - i];
  }
}

// The same of two columns of an area, k and m - k, from a wave along y on upwards in the first and from the turned one
// on downwards in the second: each factor twice, for both parts of a complex number.
template <class Real>
STICTION_INLINE void multiply_turned(Real* __restrict first, Real* __restrict second, const Real* of_first,
                                     const Real* of_second, const Real* between, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) {
    const Real one = first[i];
    const Real two = *(second - i);
    first[i] = of_first[i] * one + between[i] * two;
    *(second - i) = of_second[i] * two + between[i] * one;
  }
}

// Waves along y of which factors are made at a time.
constexpr std::size_t waves_at_once = 64;

// `own` and `turned` are the factors of both columns at waves along y up to half of `size`; θ = πk/m. Waves i of the
// one are mixed with waves size - i of the other, and the factors of both are the same.
template <class Real>
STICTION_INLINE void mix_columns_of(Real* __restrict first, Real* __restrict second, const Real* own,
                                    const Real* turned, Real sine, Real cosine, std::size_t size) {
  std::array<Real, 2 * waves_at_once> of_first;
  std::array<Real, 2 * waves_at_once> of_second;
  std::array<Real, 2 * waves_at_once> between;
  for (std::size_t from = 0; 2 * from <= size; from += waves_at_once) {
    const std::size_t count = std::min(waves_at_once, size / 2 + 1 - from);
    for (std::size_t i = 0; i < count; ++i) {
      const Real mean = Real{0.5} * (own[from + i] + turned[from + i]);
      const Real difference = Real{0.5} * (own[from + i] - turned[from + i]);
      of_first[2 * i] = of_first[2 * i + 1] = mean - difference * sine;
      of_second[2 * i] = of_second[2 * i + 1] = mean + difference * sine;
      between[2 * i] = between[2 * i + 1] = difference * cosine;
    }
    std::size_t skip = 0;
    if (from == 0) {
      multiply_turned(first, second + 1, of_first.data(), of_second.data(), between.data(), 2);
      skip = 1;
    }
    // The wave at half of an even size is turned into itself.
    const std::size_t both = size % 2 == 0 && from + count == size / 2 + 1 ? count - 1 : count;
    if (count > skip) {
      multiply_turned(first + 2 * (from + skip), second + 2 * (size - from - skip) + 1, &of_first[2 * skip],
                      &of_second[2 * skip], &between[2 * skip], 2 * (count - skip));
    }
    if (both > skip) {
      multiply_turned(second + 2 * (from + skip), first + 2 * (size - from - skip) + 1, &of_second[2 * skip],
                      &of_first[2 * skip], &between[2 * skip], 2 * (both - skip));
    }
  }
}

STICTION_MULTIVERSION
void mix_columns(float* first, float* second, const float* own, const float* turned, float sine, float cosine,
                 std::size_t size) {
  mix_columns_of(first, second, own, turned, sine, cosine, size);
}

STICTION_MULTIVERSION
void mix_columns(double* first, double* second, const double* own, const double* turned, double sine, double cosine,
                 std::size_t size) {
  mix_columns_of(first, second, own, turned, sine, cosine, size);
}

// Columns of an area in memory, one after the other, and back.
template <class Real>
void gather(const std::complex<Real>* area, std::size_t stride, const std::vector<std::size_t>& rows, std::size_t count,
            std::size_t apart, std::complex<Real>* columns) {
  for (const std::size_t row : rows) {
    const std::complex<Real>* from = area + row * stride;
    for (std::size_t column = 0; column < count; ++column) {
      columns[column * apart + row] = from[column];
    }
  }
}

template <class Real>
void scatter(const std::complex<Real>* columns, std::size_t apart, std::size_t rows, std::size_t count,
             std::size_t stride, std::complex<Real>* area) {
  for (std::size_t row = 0; row < rows; ++row) {
    std::complex<Real>* to = area + row * stride;
    for (std::size_t column = 0; column < count; ++column) {
      to[column] = columns[column * apart + row];
    }
  }
}

// Transforms of a grid that zeros fill up to so many rows and columns.
struct Shape {
  std::size_t rows;
  std::size_t columns;
  std::size_t padded_rows;
  std::size_t padded_columns;

  bool packed() const { return padded_columns % 2 == 0; }
  std::size_t waves() const { return packed() ? padded_columns / 2 : padded_columns; }
  std::size_t along_x() const { return padded_columns / 2 + 1; }  // different even factors
  std::size_t along_y() const { return padded_rows / 2 + 1; }
};

struct Plans {
  std::vector<std::pair<std::size_t, std::shared_ptr<const Waves<float>>>> singles;
  std::vector<std::pair<std::size_t, std::shared_ptr<const Waves<double>>>> doubles;

  template <class Real>
  std::shared_ptr<const Waves<Real>> of(std::size_t points) {
    auto& known = [&]() -> auto& {
      if constexpr (std::is_same_v<Real, float>) {
        return singles;
      } else {
        return doubles;
      }
    }();
    for (const auto& [size, waves] : known) {
      if (size == points) {
        return waves;
      }
    }
    return known.emplace_back(points, std::make_shared<const Waves<Real>>(points)).second;
  }
};

struct Scratch {
  Room waves;
  std::vector<std::array<Room, 5>> threads;
};

// Values times real factors of their waves, which are the same for k and -k. Factors lie by waves along x, and for each
// of these by waves along y.
template <class Real>
class Filter {
 public:
  template <class Factors>
  Filter(const Shape& shape, Factors&& factors, Plans& plans) : shape_(shape), along_x_(plans.of<Real>(shape.waves())) {
    const double norm = 1.0 / (static_cast<double>(shape.waves()) * static_cast<double>(shape.padded_rows));
    if (shape.rows > 1 || shape.padded_rows > 1) {
      along_y_ = plans.of<Real>(shape.padded_rows);
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
    const std::size_t count = shape.waves();
    own_.resize(2 * count);
    other_.resize(2 * count);
    for (std::size_t k = 0; k < count; ++k) {
      double own = norm * factors[shape.packed() || k <= count / 2 ? k : count - k];
      double other = 0.0;
      if (shape.packed()) {
        const double turned = norm * factors[count - k];
        const double angle = pi * static_cast<double>(k) / static_cast<double>(count);
        const double difference = 0.5 * (own - turned);
        own = 0.5 * (own + turned) - difference * std::sin(angle);
        other = difference * std::cos(angle);
      }
      own_[2 * k] = own_[2 * k + 1] = static_cast<Real>(own);
      other_[2 * k] = other_[2 * k + 1] = static_cast<Real>(other);
    }
  }

  void operator()(std::span<const Real> values, std::span<Real> result, Scratch& scratch, const Crew& crew) const {
    if (values.size() != shape_.rows * shape_.columns || result.size() != values.size()) {
      throw std::invalid_argument("ElasticKernel: values must be those of its grid");
    }
    scratch.threads.resize(std::max(scratch.threads.size(), crew.threads()));
    if (along_y_) {
      area(values, result, scratch, crew);
    } else {
      line(values, result, scratch.threads[0]);
      crew.check();
    }
  }

 private:
  using Complex = std::complex<Real>;

  static Real* parts(Complex* waves) { return reinterpret_cast<Real*>(waves); }

  void fill(const Real* values, Complex* packed) const {
    Real* to = parts(packed);
    if (shape_.packed()) {
      std::copy_n(values, shape_.columns, to);
      std::fill(to + shape_.columns, to + shape_.padded_columns, Real{0});
      return;
    }
    for (std::size_t i = 0; i < shape_.columns; ++i) {
      packed[i] = values[i];
    }
  }

  void take(Complex* packed, Real* values) const {
    const Real* from = parts(packed);
    if (shape_.packed()) {
      std::copy_n(from, shape_.columns, values);
      return;
    }
    for (std::size_t i = 0; i < shape_.columns; ++i) {
      values[i] = from[2 * i];
    }
  }

  void line(std::span<const Real> values, std::span<Real> result, std::array<Room, 5>& rooms) const {
    const std::size_t count = shape_.waves();
    Complex* packed = rooms[0].template waves<Real>(count);
    Complex* waves = rooms[1].template waves<Real>(count);
    fill(values.data(), packed);
    along_x_->forward(packed, waves);
    multiply_line(parts(waves), own_.data(), other_.data(), 2 * count, parts(packed));
    along_x_->back(packed, waves);
    take(waves, result.data());
  }

  void area(std::span<const Real> values, std::span<Real> result, Scratch& scratch, const Crew& crew) const {
    const std::size_t count = shape_.waves();
    const std::size_t stride = stride_of<Real>(count);
    Complex* area = scratch.waves.waves<Real>(shape_.rows * stride);
    // Rows without values, of which there are many where little touches, have no waves along x.
    std::vector<std::size_t> filled;
    for (std::size_t row = 0; row < shape_.rows; ++row) {
      const auto* from = values.data() + row * shape_.columns;
      if (std::any_of(from, from + shape_.columns, [](Real value) { return value != Real{0}; })) {
        filled.push_back(row);
      }
    }
    const std::size_t at_once = std::max<std::size_t>(numbers_at_once / count, 1);
    crew.each((filled.size() + at_once - 1) / at_once, [&](std::size_t part, std::size_t thread) {
      Complex* packed = scratch.threads[thread][0].template waves<Real>(count);
      for (std::size_t i = part * at_once; i < std::min((part + 1) * at_once, filled.size()); ++i) {
        fill(values.data() + filled[i] * shape_.columns, packed);
        along_x_->forward(packed, area + filled[i] * stride);
      }
    });
    // Columns k and m - k at a time, which are mixed; the first is its own, and the middle one where there is one.
    const std::size_t pairs = shape_.packed() ? count / 2 + 1 : count;
    const std::size_t blocks = std::max<std::size_t>(numbers_at_once / shape_.padded_rows / columns_at_once, 1);
    const std::size_t in_part = blocks * columns_at_once;
    crew.each((pairs + in_part - 1) / in_part, [&](std::size_t part, std::size_t thread) {
      const std::size_t last = std::min((part + 1) * in_part, pairs);
      for (std::size_t first = part * in_part; first < last; first += columns_at_once) {
        columns(area, stride, filled, first, std::min(first + columns_at_once, last), scratch.threads[thread]);
      }
    });
    crew.each((shape_.rows + at_once - 1) / at_once, [&](std::size_t part, std::size_t thread) {
      Complex* packed = scratch.threads[thread][0].template waves<Real>(count);
      for (std::size_t row = part * at_once; row < std::min((part + 1) * at_once, shape_.rows); ++row) {
        along_x_->back(area + row * stride, packed);
        take(packed, result.data() + row * shape_.columns);
      }
    });
  }

  // Columns from `first` to below `last`, and those that they are mixed with.
  void columns(Complex* area, std::size_t stride, const std::vector<std::size_t>& filled, std::size_t first,
               std::size_t last, std::array<Room, 5>& rooms) const {
    const std::size_t size = shape_.padded_rows;
    const std::size_t apart = stride_of<Real>(size);
    const std::size_t count = shape_.waves();
    const std::size_t many = last - first;
    Complex* values = rooms[1].template waves<Real>(columns_at_once * apart);
    std::array<Complex*, 2> waves = {rooms[2].template waves<Real>(columns_at_once * apart),
                                     rooms[3].template waves<Real>(columns_at_once * apart)};
    // The first column and the middle one are their own; the middle one is the last of all.
    const std::size_t begin = std::max<std::size_t>(first, 1);
    const std::size_t end = 2 * (last - 1) == count ? last - 1 : last;
    const std::size_t turned = shape_.packed() && end > begin ? end - begin : 0;
    // Of columns count - end + 1 to count - begin; the last of them belongs to `begin`.
    const std::array<std::pair<std::size_t, std::size_t>, 2> blocks = {{{first, many}, {count - end + 1, turned}}};
    for (std::size_t block = 0; block < 2; ++block) {
      const auto [from, width] = blocks[block];
      if (width == 0) {
        continue;
      }
      if (filled.size() < size) {
        std::fill_n(values, width * apart, Complex{});
      }
      gather(area + from, stride, filled, width, apart, values);
      for (std::size_t column = 0; column < width; ++column) {
        along_y_->forward(values + column * apart, waves[block] + column * apart);
      }
    }
    for (std::size_t k = first; k < last; ++k) {
      Complex* own = waves[0] + (k - first) * apart;
      if (!shape_.packed()) {
        scale(own, k <= count / 2 ? k : count - k);
      } else if (k >= begin && k < end) {
        mix(own, waves[1] + (end - 1 - k) * apart, k);
      } else {
        std::copy_n(own, size, values);
        mix(own, values, k);
      }
    }
    for (std::size_t block = 0; block < 2; ++block) {
      const auto [from, width] = blocks[block];
      for (std::size_t column = 0; column < width; ++column) {
        along_y_->back(waves[block] + column * apart, values + column * apart);
      }
      scatter(values, apart, shape_.rows, width, stride, area + from);
    }
  }

  void scale(Complex* waves, std::size_t k) const {
    const std::size_t size = shape_.padded_rows;
    const Real* factors = factors_.data() + k * shape_.along_y();
    for (std::size_t i = 0; i < size; ++i) {
      waves[i] *= factors[std::min(i, size - i)];
    }
  }

  void mix(Complex* first, Complex* second, std::size_t k) const {
    const std::size_t count = shape_.waves();
    const Real* own = factors_.data() + k * shape_.along_y();
    const Real* turned = factors_.data() + (count - k) * shape_.along_y();
    const double angle = pi * static_cast<double>(k) / static_cast<double>(count);
    mix_columns(parts(first), parts(second), own, turned, static_cast<Real>(std::sin(angle)),
                static_cast<Real>(std::cos(angle)), shape_.padded_rows);
  }

  Shape shape_;
  std::shared_ptr<const Waves<Real>> along_x_;
  std::shared_ptr<const Waves<Real>> along_y_;  // none of lines
  std::vector<Real> factors_;                   // of areas
  std::vector<Real> own_;                       // of lines
  std::vector<Real> other_;
};

// Waves of a sequence of 2m real numbers that is even: of its first m + 1, in place.
class EvenWaves {
 public:
  EvenWaves(std::size_t half, Plans& plans) : half_(half), waves_(plans.of<double>(half)), turns_(half + 1) {
    for (std::size_t k = 0; k <= half; ++k) {
      turns_[k] = std::polar(1.0, -pi * static_cast<double>(k) / static_cast<double>(half));
    }
  }

  void operator()(double* values, std::array<Room, 5>& rooms) const {
    std::complex<double>* packed = rooms[0].waves<double>(half_);
    std::complex<double>* waves = rooms[1].waves<double>(half_);
    const auto at = [&](std::size_t i) { return values[i <= half_ ? i : 2 * half_ - i]; };
    for (std::size_t i = 0; i < half_; ++i) {
      packed[i] = {at(2 * i), at(2 * i + 1)};
    }
    waves_->forward(packed, waves);
    for (std::size_t k = 0; k <= half_; ++k) {
      const bool ends = k == 0 || k == half_;
      const std::complex<double> one = waves[ends ? 0 : k];
      const std::complex<double> turned = std::conj(waves[ends ? 0 : half_ - k]);
      values[k] = 0.5 * ((one + turned) - std::complex<double>(0.0, 1.0) * turns_[k] * (one - turned)).real();
    }
  }

 private:
  std::size_t half_;
  std::shared_ptr<const Waves<double>> waves_;
  std::vector<std::complex<double>> turns_;
};

std::size_t even_fast_length(std::size_t points) { return 2 * fast_length(points); }

// E*|k|/2 at waves along x, and for each of them along y.
std::vector<double> stiffness(const Shape& shape, const Grid& grid, double effective_modulus) {
  std::vector<double> factors;
  factors.reserve(shape.along_x() * shape.along_y());
  const double step_x = 2 * pi / (static_cast<double>(shape.padded_columns) * grid.spacing_x);
  const double step_y = 2 * pi / (static_cast<double>(shape.padded_rows) * grid.spacing_y);
  for (std::size_t i = 0; i < shape.along_x(); ++i) {
    for (std::size_t j = 0; j < shape.along_y(); ++j) {
      const double x = step_x * static_cast<double>(i);
      const double y = step_y * static_cast<double>(j);
      factors.push_back(0.5 * effective_modulus * std::sqrt(x * x + y * y));
    }
  }
  return factors;
}

// Displacement of the origin under 1 GPa from there to the corner (x, y) of a cell, or to x on a line.
double up_to_corner(double x, double effective_modulus) {
  // The integral of -2/(π E*) ln|x|; the unit of the logarithm shifts all alike.
  return -2 / (pi * effective_modulus) * x * (std::log(std::abs(x)) - 1.0);
}

double up_to_corner(double x, double y, double effective_modulus) {
  return (x * std::asinh(y / std::abs(x)) + y * std::asinh(x / std::abs(y))) / (pi * effective_modulus);
}

double half_away(std::size_t i, double spacing) { return (static_cast<double>(i) - 0.5) * spacing; }

// Displacement of points so many rows and columns away under 1 GPa on a cell, or on a line: the row and those beyond.
void influence_of_row(const Grid& grid, double effective_modulus, std::size_t row, std::span<double> influence) {
  const std::size_t count = influence.size();
  const auto corner = [&](std::size_t i, std::size_t j) {
    const double x = half_away(j, grid.spacing_x);
    return grid.line ? up_to_corner(x, effective_modulus)
                     : up_to_corner(x, half_away(i, grid.spacing_y), effective_modulus);
  };
  const auto along = [&](std::size_t j) { return grid.line ? corner(0, j) : corner(row + 1, j) - corner(row, j); };
  double before = along(0);
  for (std::size_t j = 0; j < count; ++j) {
    const double after = along(j + 1);
    influence[j] = after - before;
    before = after;
  }
}

Shape response_shape(const Grid& grid) {
  if (grid.periodic) {
    return {grid.rows, grid.columns, grid.rows, grid.columns};
  }
  return {grid.rows, grid.columns, grid.line ? 1 : even_fast_length(grid.rows), even_fast_length(grid.columns)};
}

// Waves of the displacement under pressures, at waves along x and for each of them along y.
std::vector<double> compliance(const Shape& shape, const Grid& grid, double effective_modulus, Plans& plans,
                               Scratch& scratch, const Crew& crew) {
  if (grid.periodic) {
    std::vector<double> factors = stiffness(shape, grid, effective_modulus);
    std::transform(factors.begin(), factors.end(), factors.begin(),
                   [](double factor) { return factor > 0.0 ? 1.0 / factor : 0.0; });
    return factors;
  }
  // Even numbers of points, so that waves of the influence, which is even, are those of a quarter of it; points beyond
  // the grid, which nothing depends on, are like its last ones.
  const std::size_t width = shape.along_x();
  const std::size_t height = shape.along_y();
  std::vector<double> factors(width * height);
  const EvenWaves along_x(width - 1, plans);
  scratch.threads.resize(std::max(scratch.threads.size(), crew.threads()));
  if (grid.line) {
    influence_of_row(grid, effective_modulus, 0, {factors.data(), grid.columns});
    std::fill(factors.begin() + static_cast<std::ptrdiff_t>(grid.columns), factors.end(), factors[grid.columns - 1]);
    along_x(factors.data(), scratch.threads[0]);
    return factors;
  }
  const EvenWaves along_y(height - 1, plans);
  std::vector<double> rows(std::min(grid.rows, height) * width);
  crew.each(grid.rows, [&](std::size_t row, std::size_t thread) {
    double* values = rows.data() + row * width;
    influence_of_row(grid, effective_modulus, row, {values, grid.columns});
    std::fill(values + grid.columns, values + width, values[grid.columns - 1]);
    along_x(values, scratch.threads[thread]);
  });
  crew.each((width + columns_at_once - 1) / columns_at_once, [&](std::size_t part, std::size_t thread) {
    const std::size_t first = part * columns_at_once;
    const std::size_t last = std::min(first + columns_at_once, width);
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

// The periodic near inverse of a small area on its origin and around it, by slow sums over its waves.
std::array<double, 9> stencil_of(const Grid& grid, double effective_modulus) {
  Grid small = grid;
  small.rows = small.columns = stencil_points;
  const Shape shape = {stencil_points, stencil_points, stencil_points, stencil_points};
  const std::vector<double> factors = stiffness(shape, small, effective_modulus);
  const auto near = [&](std::size_t down, std::size_t right) {
    double sum = 0.0;
    for (std::size_t i = 0; i < stencil_points; ++i) {
      for (std::size_t j = 0; j < stencil_points; ++j) {
        const double factor =
            factors[std::min(i, stencil_points - i) * shape.along_y() + std::min(j, stencil_points - j)];
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
      stencil[i] = near(i / 3 == 1 ? 0 : 1, i % 3 == 1 ? 0 : 1);
      sum += stencil[i];
    }
  }
  stencil[4] = sum / (stencil_sum - 1);
  return stencil;
}

}  // namespace

std::size_t fast_length(std::size_t points) {
  for (std::size_t length = std::max<std::size_t>(points, 1);; ++length) {
    std::size_t rest = length;
    for (const std::size_t factor : {2U, 3U, 5U}) {
      while (rest % factor == 0) {
        rest /= factor;
      }
    }
    if (rest == 1) {
      return length;
    }
  }
}

struct Workspace::Rooms {
  Scratch scratch;
};

Workspace::Workspace() : rooms_(std::make_unique<Rooms>()) {}
Workspace::~Workspace() = default;

// Filters are made when first asked for: coarse grids need no displacement in double precision, and areas with little
// contact no near inverse.
struct ElasticKernel::Transforms {
  Shape shape;
  double effective_modulus;
  std::vector<double> compliance;
  std::mutex mutex;
  Plans plans;
  std::unique_ptr<const Filter<double>> displacement;
  std::unique_ptr<const Filter<float>> response;
  std::map<double, const Filter<float>> plates;  // by their springs; without any it is the stiffness

  // E*|k|/2 on each wave, or with springs the inverse of what both are together.
  const Filter<float>* plate(const Grid& grid, double springs) {
    const std::lock_guard lock(mutex);
    if (const auto known = plates.find(springs); known != plates.end()) {
      return &known->second;
    }
    const Shape own = {grid.rows, grid.columns, grid.rows, grid.columns};
    std::vector<double> factors = stiffness(own, grid, effective_modulus);
    if (springs > 0.0) {
      std::transform(factors.begin(), factors.end(), factors.begin(),
                     [&](double factor) { return 1.0 / (factor + springs); });
    }
    return &plates.emplace(springs, Filter<float>(own, factors, plans)).first->second;
  }
};

ElasticKernel::ElasticKernel(const Grid& grid, double effective_modulus, const Crew& crew) : grid_(grid) {
  if (grid.size() == 0 || !(grid.spacing_x > 0.0) || !(grid.spacing_y > 0.0) || !(effective_modulus > 0.0) ||
      (grid.line && grid.rows != 1)) {
    throw std::invalid_argument(
        "ElasticKernel: a grid has points, spacings above 0 and, as a line, one row; a modulus "
        "is above 0");
  }
  if (!grid.line) {
    stencil_ = stencil_of(grid, effective_modulus);
  }
  transforms_ = std::make_unique<Transforms>();
  transforms_->shape = response_shape(grid);
  transforms_->effective_modulus = effective_modulus;
  Scratch scratch;
  transforms_->compliance = compliance(transforms_->shape, grid, effective_modulus, transforms_->plans, scratch, crew);
  transforms_->response =
      std::make_unique<const Filter<float>>(transforms_->shape, transforms_->compliance, transforms_->plans);
}

ElasticKernel::~ElasticKernel() = default;

void ElasticKernel::displacement(Values pressure, std::span<double> moved, Workspace& workspace,
                                 const Crew& crew) const {
  {
    const std::lock_guard lock(transforms_->mutex);
    if (!transforms_->displacement) {
      transforms_->displacement = std::make_unique<const Filter<double>>(
          transforms_->shape, std::move(transforms_->compliance), transforms_->plans);
      transforms_->compliance = {};
    }
  }
  (*transforms_->displacement)(pressure, moved, workspace.rooms_->scratch, crew);
}

void ElasticKernel::displacement(std::span<const float> pressure, std::span<float> moved, Workspace& workspace,
                                 const Crew& crew) const {
  (*transforms_->response)(pressure, moved, workspace.rooms_->scratch, crew);
}

void ElasticKernel::stiffened(std::span<const float> residual, std::span<float> result, Workspace& workspace,
                              const Crew& crew) const {
  (*transforms_->plate(grid_, 0.0))(residual, result, workspace.rooms_->scratch, crew);
}

void ElasticKernel::softened(std::span<const float> loads, double springs, std::span<float> result,
                             Workspace& workspace, const Crew& crew) const {
  if (!(springs > 0.0)) {
    throw std::invalid_argument("ElasticKernel: springs must be above 0");
  }
  (*transforms_->plate(grid_, springs))(loads, result, workspace.rooms_->scratch, crew);
}

double even_deviation(const Grid& grid, double effective_modulus) {
  // By what lies on both sides of a point: sums up to the corners of cells, of the points of a quarter.
  const auto moved = [&](std::size_t row, std::size_t column) {
    double sum = 0.0;
    for (const std::size_t j : {column + 1, grid.columns - column}) {
      const double x = half_away(j, grid.spacing_x);
      if (grid.line) {
        sum += up_to_corner(x, effective_modulus);
        continue;
      }
      for (const std::size_t i : {row + 1, grid.rows - row}) {
        sum += up_to_corner(x, half_away(i, grid.spacing_y), effective_modulus);
      }
    }
    return sum;
  };
  const auto alike = [](std::size_t i, std::size_t count) { return 2 * i + 1 == count ? 1.0 : 2.0; };
  const double shift = moved(0, 0);
  double sum = 0.0;
  double squares = 0.0;
  for (std::size_t row = 0; 2 * row < grid.rows; ++row) {
    for (std::size_t column = 0; 2 * column < grid.columns; ++column) {
      const double away = moved(row, column) - shift;
      const double weight = alike(row, grid.rows) * alike(column, grid.columns);
      sum += weight * away;
      squares += weight * away * away;
    }
  }
  const auto count = static_cast<double>(grid.size());
  return std::sqrt(std::max(squares / count - sum / count * (sum / count), 0.0));
}

}  // namespace stiction
