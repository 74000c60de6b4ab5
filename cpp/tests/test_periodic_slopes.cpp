#include "stiction/periodic_slopes.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

using stiction::Index;
using stiction::Matrix;

TEST_CASE("periodic_slopes: returns exact slopes of waves for odd and even numbers of points") {
  const double spacing_x = 0.5;
  const double spacing_y = 0.2;
  for (const Index rows : {1, 2, 3, 8, 9, 30}) {
    for (const Index columns : {5, 8, 17, 24}) {
      CAPTURE(rows);
      CAPTURE(columns);
      const double x_number = 2.0 * 2.0 * std::numbers::pi / (static_cast<double>(columns) * spacing_x);
      // Along two rows, heights can only vary with the Nyquist wavenumber, at which the computed slope is 0.
      const double y_number = 2.0 * std::numbers::pi / (static_cast<double>(rows) * spacing_y);
      Matrix heights(rows, columns);
      Matrix expected_x(rows, columns);
      Matrix expected_y(rows, columns);
      for (Index j = 0; j < rows; ++j) {
        for (Index i = 0; i < columns; ++i) {
          const double x = x_number * static_cast<double>(i) * spacing_x;
          const double y = y_number * static_cast<double>(j) * spacing_y;
          heights(j, i) = 3.0 + std::sin(x + 0.3) * std::cos(y);
          expected_x(j, i) = x_number * std::cos(x + 0.3) * std::cos(y);
          expected_y(j, i) = rows == 2 ? 0.0 : -y_number * std::sin(x + 0.3) * std::sin(y);
        }
      }
      Matrix along_x = Matrix::Constant(rows, columns, 7.0);
      Matrix along_y = Matrix::Constant(rows, columns, 7.0);
      stiction::periodic_slopes(heights, {spacing_x, spacing_y}, along_x, along_y);
      CHECK((along_x - expected_x).cwiseAbs().maxCoeff() < 1e-13);
      if (rows > 1) {
        CHECK((along_y - expected_y).cwiseAbs().maxCoeff() < 1e-13);
      }
    }
  }
}

TEST_CASE("periodic_slopes: returns the slopes of a part of a larger array") {
  const Matrix heights = Matrix::Random(12, 20);
  const Matrix part = heights.block(2, 3, 7, 9);
  Matrix x(7, 9);
  Matrix y(7, 9);
  Matrix part_x(7, 9);
  Matrix part_y(7, 9);
  stiction::periodic_slopes(heights.block(2, 3, 7, 9), {1.0, 1.0}, x, y);
  stiction::periodic_slopes(part, {1.0, 1.0}, part_x, part_y);
  CHECK(x == part_x);
  CHECK(y == part_y);
}

TEST_CASE("periodic_slopes: rejects an empty map") {
  Matrix empty(0, 0);
  CHECK_THROWS_AS(stiction::periodic_slopes(empty, {1.0, 1.0}, empty, empty), std::invalid_argument);
}
