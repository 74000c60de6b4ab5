#include "stiction/minima.hpp"
#include "stiction/spline.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>
#include <vector>

using std::numbers::pi;
using stiction::bicubic_at;
using stiction::Index;
using stiction::Jet;
using stiction::Matrix;
using stiction::Minimum;

namespace {

template <class Function>
Matrix coefficients_of(Index rows, Index columns, const Function& function) {
  Matrix heights = Matrix::Zero(rows + 2, columns + 2);
  for (Index j = 0; j < rows; ++j) {
    for (Index i = 0; i < columns; ++i) {
      heights(j + 1, i + 1) = function(static_cast<double>(i), static_cast<double>(j));
    }
  }
  stiction::natural_bicubic(heights);
  return heights;
}

Matrix noise(Index rows, Index columns, unsigned seed) {
  std::mt19937_64 random(seed);
  return coefficients_of(rows, columns, [&](double, double) { return static_cast<double>(random() >> 11) * 0x1p-53; });
}

std::vector<Minimum> minima(const Matrix& coefficients, double highest) {
  return stiction::minima(coefficients, {0, 0, coefficients.rows() - 3, coefficients.cols() - 3}, highest);
}

constexpr double no_limit = std::numeric_limits<double>::infinity();

}  // namespace

TEST_CASE("natural_bicubic: interpolates the points and equals the profile spline along rows and columns") {
  constexpr Index rows = 9;
  constexpr Index columns = 23;
  constexpr double tolerance = 1e-14;
  std::mt19937_64 random(3);
  Matrix heights = Matrix::Zero(rows + 2, columns + 2);
  for (Index j = 1; j <= rows; ++j) {
    for (Index i = 1; i <= columns; ++i) {
      heights(j, i) = static_cast<double>(random() >> 11) * 0x1p-53;
    }
  }
  Matrix coefficients = heights;
  stiction::natural_bicubic(coefficients);
  Matrix along_x(rows, columns);
  Matrix along_y(rows, columns);
  stiction::natural_slopes(heights.block(1, 1, rows, columns), {0.5, 2.0}, along_x, along_y);
  for (Index j = 0; j < rows; ++j) {
    std::vector<double> row(columns);
    std::vector<double> slope(columns);
    std::vector<double> curvature(columns);
    for (Index i = 0; i < columns; ++i) {
      row[static_cast<std::size_t>(i)] = heights(j + 1, i + 1);
    }
    stiction::natural_spline(row, 1.0, slope, curvature);
    for (Index i = 0; i < columns; ++i) {
      // At the last point of a row or column, the spline is evaluated in the preceding cell, with the same result.
      const Index column = std::min(i, columns - 2);
      const Index cell = std::min(j, rows - 2);
      const Jet at =
          bicubic_at(coefficients, cell, column, static_cast<double>(i - column), static_cast<double>(j - cell));
      CHECK(std::abs(at.value - heights(j + 1, i + 1)) < tolerance);
      CHECK(std::abs(at.x - slope[static_cast<std::size_t>(i)]) < 10 * tolerance);
      CHECK(std::abs(at.x / 0.5 - along_x(j, i)) < 10 * tolerance);
      CHECK(std::abs(at.y / 2.0 - along_y(j, i)) < 10 * tolerance);
      CHECK(std::abs(at.xx - curvature[static_cast<std::size_t>(i)]) < 10 * tolerance);
      if (j == 0 || j == rows - 1) {
        CHECK(std::abs(at.yy) < 10 * tolerance);
      }
    }
  }
}

TEST_CASE("bicubic_at: derivatives match finite differences") {
  const Matrix coefficients = noise(6, 7, 5);
  constexpr double h = 1e-5;
  const auto at = [&](double u, double v) { return bicubic_at(coefficients, 2, 3, u, v); };
  const Jet middle = at(0.3, 0.8);
  CHECK(middle.x == doctest::Approx((at(0.3 + h, 0.8).value - at(0.3 - h, 0.8).value) / (2 * h)).epsilon(1e-8));
  CHECK(middle.y == doctest::Approx((at(0.3, 0.8 + h).value - at(0.3, 0.8 - h).value) / (2 * h)).epsilon(1e-8));
  CHECK(middle.xx == doctest::Approx((at(0.3 + h, 0.8).x - at(0.3 - h, 0.8).x) / (2 * h)).epsilon(1e-8));
  CHECK(middle.xy == doctest::Approx((at(0.3, 0.8 + h).x - at(0.3, 0.8 - h).x) / (2 * h)).epsilon(1e-8));
  CHECK(middle.yy == doctest::Approx((at(0.3, 0.8 + h).y - at(0.3, 0.8 - h).y) / (2 * h)).epsilon(1e-8));
}

TEST_CASE("minima: finds one minimum per period for any grid offset, and none on the edge") {
  // The error of the spline's slope is (2π/16)³ / 48 of the largest slope. This error is of third order in the spacing.
  constexpr double tolerance = 2e-3;
  for (const double shift : {0.0, 1e-9, 0.25, 0.5, 0.9999999999}) {
    const Matrix coefficients = coefficients_of(65, 97, [&](double x, double y) {
      return -std::cos(2 * pi * (x - shift - 8) / 16) - std::cos(2 * pi * (y + shift - 8) / 16);
    });
    const auto result = minima(coefficients, no_limit);
    // There is one minimum every 16 points along each axis. The first minimum is at x = 8 + shift and y = 8 - shift.
    REQUIRE(result.size() == 4 * 6);
    for (const Minimum& local_minimum : result) {
      CHECK(std::abs(std::remainder(static_cast<double>(local_minimum.column) + local_minimum.u - shift - 8, 16)) <
            tolerance);
      CHECK(std::abs(std::remainder(static_cast<double>(local_minimum.row) + local_minimum.v + shift - 8, 16)) <
            tolerance);
      CHECK(local_minimum.u >= -1e-6);
      CHECK(local_minimum.u < 1.0 - 1e-6);
      CHECK(local_minimum.v >= -1e-6);
      CHECK(local_minimum.v < 1.0 - 1e-6);
    }
    CHECK(minima(coefficients, -1.9).size() == result.size());
    CHECK(minima(coefficients, -2.1).empty());
  }
}

TEST_CASE("minima: finds the same minima of rough maps as multistart Newton") {
  for (const unsigned seed : {1U, 2U, 3U}) {
    constexpr Index size = 40;
    const Matrix coefficients = noise(size, size, seed);
    const auto result = minima(coefficients, no_limit);
    // Reference result: minima found in each cell by Newton's method from 64 starting points in the cell.
    std::size_t expected_count = 0;
    for (Index row = 0; row < size - 1; ++row) {
      for (Index column = 0; column < size - 1; ++column) {
        std::vector<std::pair<double, double>> expected;
        for (int start = 0; start < 64; ++start) {
          double u = (0.5 + start % 8) / 8;
          double v = (0.5 + start / 8) / 8;
          for (int i = 0; i < 50; ++i) {
            const Jet at = bicubic_at(coefficients, row, column, u, v);
            const double determinant = at.xx * at.yy - at.xy * at.xy;
            u -= (at.yy * at.x - at.xy * at.y) / determinant;
            v -= (at.xx * at.y - at.xy * at.x) / determinant;
          }
          const Jet at = bicubic_at(coefficients, row, column, u, v);
          const bool converged = std::abs(at.x) + std::abs(at.y) < 1e-12 && at.xx > 0 &&
                                 at.xx * at.yy > at.xy * at.xy && u >= 0 && u < 1 && v >= 0 && v < 1;
          bool is_duplicate = false;
          for (const auto& position : expected) {
            is_duplicate = is_duplicate || std::abs(position.first - u) + std::abs(position.second - v) < 1e-6;
          }
          if (converged && !is_duplicate) {
            expected.emplace_back(u, v);
          }
        }
        expected_count += expected.size();
        for (const auto& position : expected) {
          bool is_found = false;
          for (const Minimum& local_minimum : result) {
            is_found = is_found || (local_minimum.row == row && local_minimum.column == column &&
                                    std::abs(local_minimum.u - position.first) < 1e-6 &&
                                    std::abs(local_minimum.v - position.second) < 1e-6);
          }
          CHECK(is_found);
        }
      }
    }
    CHECK(result.size() == expected_count);
  }
}

TEST_CASE("minima: a level valley has no minimum") {
  CHECK(minima(coefficients_of(40, 50, [](double x, double) { return std::sin(0.3 * x) - 7.0; }), no_limit).empty());
  CHECK(minima(coefficients_of(40, 50, [](double, double y) { return std::sin(0.3 * y) - 7.0; }), no_limit).empty());
  CHECK(minima(coefficients_of(8, 8, [](double, double) { return 3.1; }), no_limit).empty());
}

TEST_CASE("natural_bicubic: maps that are too small throw") {
  Matrix small = Matrix::Zero(5, 9);
  CHECK_THROWS_AS(stiction::natural_bicubic(small), std::invalid_argument);
  Matrix slopes(3, 1);
  CHECK_THROWS_AS(stiction::natural_slopes(slopes, {1.0, 1.0}, slopes, slopes), std::invalid_argument);
}
