#include "stiction/periodic_slopes.hpp"

#include "fftw.hpp"

#include <algorithm>
#include <array>
#include <complex>
#include <numbers>
#include <stdexcept>
#include <vector>

namespace stiction {
namespace {

// Number of pairs of columns per strip: in one row, the heights of 4 pairs of columns fill a cache line.
constexpr Index pairs_per_strip = 4;

// Derivatives of two periodic lines by one Fourier transform, whose input has one line as its imaginary part.
class PairDerivative {
 public:
  PairDerivative(Index points, double spacing)
      : fft_(static_cast<std::size_t>(points)), factors_(static_cast<std::size_t>(points)) {
    const auto count = static_cast<double>(points);
    for (Index i = 0; i < points; ++i) {
      // A wave with the Nyquist wavenumber gets the slope 0, because heights at grid points do not define its slope.
      const Index waves = 2 * i == points ? 0 : (2 * i < points ? i : i - points);
      factors_[static_cast<std::size_t>(i)] =
          2.0 * std::numbers::pi * static_cast<double>(waves) / (count * spacing) / count;
    }
  }

  // The buffer must be aligned.
  void replace(std::complex<double>* values) {
    std::complex<double>* coefficients = coefficients_.get<double>(factors_.size());
    fft_.forward(values, coefficients);
    for (std::size_t i = 0; i < factors_.size(); ++i) {
      coefficients[i] = {-factors_[i] * coefficients[i].imag(), factors_[i] * coefficients[i].real()};
    }
    fft_.inverse(coefficients, values);
  }

 private:
  ComplexFft<double> fft_;
  std::vector<double> factors_;  // wave numbers [1/µm], divided by the number of points
  AlignedBuffer coefficients_;
};

void slopes_along_rows(const MatrixView& heights, double spacing, Eigen::Ref<Matrix> slopes) {
  const Index columns = heights.cols();
  PairDerivative derivative(columns, spacing);
  AlignedBuffer buffer;
  std::complex<double>* values = buffer.get<double>(static_cast<std::size_t>(columns));
  for (Index row = 0; row < heights.rows(); row += 2) {
    const bool paired = row + 1 < heights.rows();
    for (Index i = 0; i < columns; ++i) {
      values[i] = {heights(row, i), paired ? heights(row + 1, i) : 0.0};
    }
    derivative.replace(values);
    for (Index i = 0; i < columns; ++i) {
      slopes(row, i) = values[i].real();
    }
    for (Index i = 0; i < columns && paired; ++i) {
      slopes(row + 1, i) = values[i].imag();
    }
  }
}

void slopes_along_columns(const MatrixView& heights, double spacing, Eigen::Ref<Matrix> slopes) {
  const Index rows = heights.rows();
  PairDerivative derivative(rows, spacing);
  std::array<AlignedBuffer, pairs_per_strip> buffers;
  std::array<std::complex<double>*, pairs_per_strip> values{};
  for (std::size_t pair = 0; pair < values.size(); ++pair) {
    values[pair] = buffers[pair].get<double>(static_cast<std::size_t>(rows));
  }
  for (Index first = 0; first < heights.cols(); first += 2 * pairs_per_strip) {
    const Index columns = std::min(2 * pairs_per_strip, heights.cols() - first);
    const auto pairs = static_cast<std::size_t>((columns + 1) / 2);
    for (Index row = 0; row < rows; ++row) {
      std::array<double, 2 * pairs_per_strip> strip{};
      std::copy_n(heights.data() + row * heights.outerStride() + first, columns, strip.begin());
      for (std::size_t pair = 0; pair < pairs; ++pair) {
        values[pair][row] = {strip[2 * pair], strip[2 * pair + 1]};
      }
    }
    for (std::size_t pair = 0; pair < pairs; ++pair) {
      derivative.replace(values[pair]);
    }
    for (Index row = 0; row < rows; ++row) {
      std::array<double, 2 * pairs_per_strip> strip{};
      for (std::size_t pair = 0; pair < pairs; ++pair) {
        strip[2 * pair] = values[pair][row].real();
        strip[2 * pair + 1] = values[pair][row].imag();
      }
      std::copy_n(strip.begin(), columns, slopes.data() + row * slopes.outerStride() + first);
    }
  }
}

}  // namespace

void periodic_slopes(const MatrixView& heights, const Vector2& spacing, Eigen::Ref<Matrix> along_x,
                     Eigen::Ref<Matrix> along_y) {
  if (heights.size() == 0) {
    throw std::invalid_argument("periodic_slopes: the map must not be empty");
  }
  slopes_along_rows(heights, spacing.x(), along_x);
  if (heights.rows() > 1) {
    slopes_along_columns(heights, spacing.y(), along_y);
  }
}

}  // namespace stiction
