#include "stiction/elastic_kernel.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>
#include <vector>

using stiction::Crew;
using stiction::ElasticKernel;
using stiction::Grid;
using stiction::Workspace;

namespace {

constexpr double pi = std::numbers::pi;
constexpr double modulus = 10.0;
constexpr double round_off = 1e-12;
constexpr double single = 2e-6;  // of transforms in single precision

// Some numbers without order.
std::vector<double> numbers(std::size_t count) {
  std::vector<double> result(count);
  for (std::size_t i = 0; i < count; ++i) {
    result[i] = std::sin(1.0 + 12.9898 * static_cast<double>(i * i % 1009));
  }
  return result;
}

// Wave by wave: `factor` of the length of each wave vector times it.
template <class Factor>
std::vector<double> by_waves(const Grid& grid, const std::vector<double>& values, Factor factor) {
  std::vector<double> result(values.size(), 0.0);
  const auto wave = [](std::size_t i, std::size_t count, double spacing) {
    const auto signed_i = static_cast<double>(i) - (2 * i > count ? static_cast<double>(count) : 0.0);
    return 2 * pi * signed_i / (static_cast<double>(count) * spacing);
  };
  std::vector<double> shape(values.size(), 0.0);  // the result of a 1 at the first point
  for (std::size_t i = 0; i < grid.rows; ++i) {
    for (std::size_t j = 0; j < grid.columns; ++j) {
      const double ky = grid.line ? 0.0 : wave(i, grid.rows, grid.spacing_y);
      const double kx = wave(j, grid.columns, grid.spacing_x);
      const double size = std::sqrt(kx * kx + ky * ky);
      for (std::size_t row = 0; row < grid.rows; ++row) {
        for (std::size_t column = 0; column < grid.columns; ++column) {
          shape[row * grid.columns + column] +=
              factor(size) *
              std::cos(2 * pi *
                       (static_cast<double>(i * row % grid.rows) / static_cast<double>(grid.rows) +
                        static_cast<double>(j * column % grid.columns) / static_cast<double>(grid.columns))) /
              static_cast<double>(values.size());
        }
      }
    }
  }
  for (std::size_t to = 0; to < values.size(); ++to) {
    for (std::size_t from = 0; from < values.size(); ++from) {
      const std::size_t row = (to / grid.columns + grid.rows - from / grid.columns) % grid.rows;
      const std::size_t column = (to % grid.columns + grid.columns - from % grid.columns) % grid.columns;
      result[to] += shape[row * grid.columns + column] * values[from];
    }
  }
  return result;
}

// Cell by cell, each a rectangle of even pressure, or a part of a line.
std::vector<double> by_cells(const Grid& grid, const std::vector<double>& values) {
  const auto corner = [&](double x, double y) {
    if (grid.line) {
      return -2 * x * (std::log(std::abs(x)) - 1);
    }
    const double r = std::hypot(x, y);
    return x * std::log(y + r) + y * std::log(x + r);
  };
  std::vector<double> result(values.size(), 0.0);
  for (std::size_t to = 0; to < values.size(); ++to) {
    for (std::size_t from = 0; from < values.size(); ++from) {
      const auto away = [](std::size_t a, std::size_t b) {
        return std::abs(static_cast<double>(a) - static_cast<double>(b));
      };
      const double x = away(to % grid.columns, from % grid.columns) * grid.spacing_x;
      const double y = away(to / grid.columns, from / grid.columns) * grid.spacing_y;
      const double a = 0.5 * grid.spacing_x;
      const double b = 0.5 * grid.spacing_y;
      const double moved =
          grid.line ? corner(x + a, 0) - corner(x - a, 0)
                    : corner(x + a, y + b) - corner(x - a, y + b) - corner(x + a, y - b) + corner(x - a, y - b);
      result[to] += values[from] * moved / (pi * modulus);
    }
  }
  return result;
}

double largest(const std::vector<double>& values) {
  double most = 0.0;
  for (const double value : values) {
    most = std::max(most, std::abs(value));
  }
  return most;
}

std::vector<Grid> grids(bool periodic) {
  return {{1, 2, 1.0, 0.1, true, periodic},    {1, 97, 1.0, 0.1, true, periodic},   {1, 96, 1.0, 0.1, true, periodic},
          {12, 15, 0.2, 0.1, false, periodic}, {9, 16, 0.1, 0.1, false, periodic},  {17, 34, 0.1, 0.3, false, periodic},
          {2, 2, 0.1, 0.1, false, periodic},   {1, 6, 0.1, 0.1, false, periodic},   {7, 4, 0.1, 0.1, false, periodic},
          {128, 4, 0.1, 0.1, false, periodic}, {129, 2, 0.1, 0.1, false, periodic}, {70, 6, 0.1, 0.1, false, periodic}};
}

}  // namespace

TEST_CASE("displacements are the sums over waves, or over cells") {
  for (const bool periodic : {true, false}) {
    for (const Grid& grid : grids(periodic)) {
      CAPTURE(grid.rows);
      CAPTURE(grid.columns);
      CAPTURE(periodic);
      const ElasticKernel kernel(grid, modulus);
      std::vector<double> pressure = numbers(grid.size());
      if (grid.rows > 4) {  // a row without any
        std::fill_n(pressure.begin() + static_cast<std::ptrdiff_t>(2 * grid.columns), grid.columns, 0.0);
      }
      const std::vector<double> expected =
          periodic ? by_waves(grid, pressure, [](double k) { return k > 0 ? 2 / (modulus * k) : 0.0; })
                   : by_cells(grid, pressure);
      const double unit = std::max(largest(expected), grid.spacing_x / modulus);
      Workspace workspace;
      std::vector<double> moved(grid.size());
      kernel.displacement(pressure, moved, workspace);
      const std::vector<float> step(pressure.begin(), pressure.end());
      std::vector<float> response(grid.size());
      kernel.displacement(step, response, workspace);
      for (std::size_t i = 0; i < grid.size(); ++i) {
        CHECK(std::abs(moved[i] - expected[i]) <= round_off * unit);
        CHECK(std::abs(static_cast<double>(response[i]) - expected[i]) <= 5 * single * unit);
      }
    }
  }
}

TEST_CASE("the stiffness is E*|k|/2 of each wave, of free grids as of periodic ones") {
  for (const bool periodic : {true, false}) {
    for (const Grid& grid : grids(periodic)) {
      const ElasticKernel kernel(grid, modulus);
      const std::vector<double> moved = numbers(grid.size());
      const std::vector<double> expected = by_waves(grid, moved, [](double k) { return 0.5 * modulus * k; });
      Workspace workspace;
      const std::vector<float> residual(moved.begin(), moved.end());
      std::vector<float> result(grid.size());
      kernel.stiffened(residual, result, workspace);
      for (std::size_t i = 0; i < grid.size(); ++i) {
        CHECK(std::abs(static_cast<double>(result[i]) - expected[i]) <= single * largest(expected));
      }
    }
  }
}

TEST_CASE("threads change no bits, and a checkpoint ends them all") {
  const Grid grid{300, 280, 0.1, 0.1, false, false};
  const ElasticKernel kernel(grid, modulus);
  const std::vector<double> pressure = numbers(grid.size());
  std::vector<double> alone(grid.size());
  Workspace workspace;
  kernel.displacement(pressure, alone, workspace);
  for (const std::size_t threads : {2U, 3U}) {
    const Crew crew(threads);
    std::vector<double> together(grid.size());
    kernel.displacement(pressure, together, workspace, crew);
    CHECK(together == alone);
    CHECK(ElasticKernel(grid, modulus, crew).stencil() == kernel.stencil());
  }
  for (const std::size_t threads : {1U, 2U}) {
    const Crew crew(threads, stiction::Checkpoint([] { throw std::length_error("stop"); }));
    std::vector<double> moved(grid.size());
    const auto go_on = [&] {
      for (int i = 0; i < 100; ++i) {
        kernel.displacement(pressure, moved, workspace, crew);
      }
    };
    CHECK_THROWS_AS(go_on(), std::length_error);
  }
}

TEST_CASE("what one thread throws comes out, and the crew goes on") {
  const Crew crew(3);
  CHECK(crew.threads() == 3);
  const auto failing = [&] {
    crew.each(50, [](std::size_t part, std::size_t) {
      if (part == 33) {
        throw std::range_error("part");
      }
    });
  };
  CHECK_THROWS_AS(failing(), std::range_error);
  std::vector<int> done(50);
  crew.each(done.size(), [&](std::size_t part, std::size_t) { ++done[part]; });
  CHECK(std::count(done.begin(), done.end(), 1) == 50);
}

TEST_CASE("the deviation under an even pressure is that of its displacements") {
  for (const Grid& grid : grids(false)) {
    const std::vector<double> moved = by_cells(grid, std::vector<double>(grid.size(), 1.0));
    double mean = 0.0;
    double squares = 0.0;
    for (const double one : moved) {
      mean += one / static_cast<double>(grid.size());
    }
    for (const double one : moved) {
      squares += (one - mean) * (one - mean) / static_cast<double>(grid.size());
    }
    CHECK(stiction::even_deviation(grid, modulus) == doctest::Approx(std::sqrt(squares)).epsilon(1e-9));
  }
}

TEST_CASE("lengths of fast transforms, and grids that are none") {
  CHECK(stiction::fast_length(1) == 1);
  CHECK(stiction::fast_length(7) == 8);
  CHECK(stiction::fast_length(1999) == 2000);
  CHECK_THROWS_AS(ElasticKernel({1, 0, 1.0, 1.0, true, false}, modulus), std::invalid_argument);
  CHECK_THROWS_AS(ElasticKernel({2, 4, 1.0, 1.0, true, false}, modulus), std::invalid_argument);
  CHECK_THROWS_AS(ElasticKernel({1, 4, 1.0, 0.0, true, false}, modulus), std::invalid_argument);
  CHECK_THROWS_AS(ElasticKernel({1, 4, 1.0, 1.0, true, false}, std::nan("")), std::invalid_argument);
  const ElasticKernel kernel({1, 4, 1.0, 1.0, true, false}, modulus);
  Workspace workspace;
  std::vector<double> moved(4);
  CHECK_THROWS_AS(kernel.displacement(std::vector<double>(5), moved, workspace), std::invalid_argument);
}
