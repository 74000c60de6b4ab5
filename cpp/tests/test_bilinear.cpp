#include "stiction/bilinear.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>

using stiction::Index;
using stiction::Matrix;

namespace {

Matrix tabulate_bilinear_function(Index rows, Index columns) {
  Matrix table(rows, columns);
  for (Index i = 0; i < rows; ++i) {
    for (Index j = 0; j < columns; ++j) {
      const auto row = static_cast<double>(i);
      const auto column = static_cast<double>(j);
      table(i, j) = 1.0 + 2.0 * row + 3.0 * column - 0.5 * row * column;
    }
  }
  return table;
}

}  // namespace

TEST_CASE("interpolate_table: is exact for a bilinear function") {
  const Matrix table = tabulate_bilinear_function(5, 4);
  const std::array rows{0.0, 4.0, 4.0, 0.25, 3.75, 2.0};
  const std::array columns{0.0, 3.0, 0.5, 2.5, 1.125, 1.0};
  std::array<double, 6> values{};
  stiction::interpolate_table(table, rows, columns, values);
  for (std::size_t i = 0; i < values.size(); ++i) {
    CAPTURE(i);
    CHECK(values[i] ==
          doctest::Approx(1.0 + 2.0 * rows[i] + 3.0 * columns[i] - 0.5 * rows[i] * columns[i]).epsilon(1e-14));
  }
}

TEST_CASE("interpolate_table: limits indices to the table, and returns NaN at NaN") {
  const Matrix table = tabulate_bilinear_function(2, 3);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const std::array rows{-1.0, 5.0, infinity, nan, 0.0};
  const std::array columns{-0.5, 2.5, -infinity, 1.0, nan};
  std::array<double, 5> values{};
  stiction::interpolate_table(table, rows, columns, values);
  CHECK(values[0] == table(0, 0));
  CHECK(values[1] == table(1, 2));
  CHECK(values[2] == table(1, 0));
  CHECK(std::isnan(values[3]));
  CHECK(std::isnan(values[4]));
}

TEST_CASE("interpolate_table: interpolates a part of a larger table") {
  const Matrix table = tabulate_bilinear_function(6, 7);
  const std::array index{0.5};
  std::array<double, 1> value{};
  stiction::interpolate_table(table.block(1, 2, 3, 4), index, index, value);
  CHECK(value[0] == doctest::Approx(1.0 + 2.0 * 1.5 + 3.0 * 2.5 - 0.5 * 1.5 * 2.5));
}

TEST_CASE("interpolate_table: rejects a table with a single row or column, and lengths that differ") {
  const std::array index{0.0, 1.0};
  std::array<double, 2> values{};
  CHECK_THROWS_AS(stiction::interpolate_table(Matrix::Zero(1, 3), index, index, values), std::invalid_argument);
  CHECK_THROWS_AS(stiction::interpolate_table(Matrix::Zero(3, 1), index, index, values), std::invalid_argument);
  const Matrix table = Matrix::Zero(2, 2);
  const std::array single{0.0};
  CHECK_THROWS_AS(stiction::interpolate_table(table, single, index, values), std::invalid_argument);
  CHECK_THROWS_AS(stiction::interpolate_table(table, index, single, values), std::invalid_argument);
}
