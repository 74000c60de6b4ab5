#include "stiction/elastic_kernel.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>
#include <vector>

using stiction::ElasticKernel;
using stiction::Grid;
using stiction::ThreadPool;
using stiction::Workspace;

namespace {

constexpr double pi = std::numbers::pi;
constexpr double modulus = 10.0;
constexpr double round_off = 1e-12;
constexpr double single_tolerance = 2e-6;

std::vector<double> pseudo_random(std::size_t count) {
  std::vector<double> result(count);
  for (std::size_t i = 0; i < count; ++i) {
    result[i] = std::sin(1.0 + 12.9898 * static_cast<double>(i * i % 1009));
  }
  return result;
}

// Reference result: multiply each Fourier component of `values` by factor(|k|), and add up the components one by one.
template <class Factor>
std::vector<double> filter_directly(const Grid& grid, const std::vector<double>& values, Factor factor) {
  std::vector<double> result(values.size(), 0.0);
  const auto wave = [](std::size_t i, std::size_t count, double spacing) {
    const auto signed_i = static_cast<double>(i) - (2 * i > count ? static_cast<double>(count) : 0.0);
    return 2 * pi * signed_i / (static_cast<double>(count) * spacing);
  };
  std::vector<double> shape(values.size(), 0.0);  // response to a value of 1 at the first point
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

// Reference result: add up the displacements due to single cells, which are loaded rectangles or segments of a line.
std::vector<double> displacement_directly(const Grid& grid, const std::vector<double>& values) {
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
      const double displacement =
          grid.line ? corner(x + a, 0) - corner(x - a, 0)
                    : corner(x + a, y + b) - corner(x - a, y + b) - corner(x + a, y - b) + corner(x - a, y - b);
      result[to] += values[from] * displacement / (pi * modulus);
    }
  }
  return result;
}

double max_abs(const std::vector<double>& values) {
  double result = 0.0;
  for (const double value : values) {
    result = std::max(result, std::abs(value));
  }
  return result;
}

std::vector<Grid> grids(bool periodic) {
  return {{1, 2, 1.0, 0.1, true, periodic},    {1, 97, 1.0, 0.1, true, periodic},   {1, 96, 1.0, 0.1, true, periodic},
          {12, 15, 0.2, 0.1, false, periodic}, {9, 16, 0.1, 0.1, false, periodic},  {17, 34, 0.1, 0.3, false, periodic},
          {2, 2, 0.1, 0.1, false, periodic},   {1, 6, 0.1, 0.1, false, periodic},   {7, 4, 0.1, 0.1, false, periodic},
          {128, 4, 0.1, 0.1, false, periodic}, {129, 2, 0.1, 0.1, false, periodic}, {70, 6, 0.1, 0.1, false, periodic}};
}

}  // namespace

TEST_CASE("ElasticKernel: displacements match direct sums over wave vectors or cells") {
  for (const bool periodic : {true, false}) {
    for (const Grid& grid : grids(periodic)) {
      CAPTURE(grid.rows);
      CAPTURE(grid.columns);
      CAPTURE(periodic);
      const ElasticKernel kernel(grid, modulus);
      std::vector<double> pressure = pseudo_random(grid.size());
      if (grid.rows > 4) {
        std::fill_n(pressure.begin() + static_cast<std::ptrdiff_t>(2 * grid.columns), grid.columns, 0.0);
      }
      const std::vector<double> expected =
          periodic ? filter_directly(grid, pressure, [](double k) { return k > 0 ? 2 / (modulus * k) : 0.0; })
                   : displacement_directly(grid, pressure);
      const double unit = std::max(max_abs(expected), grid.spacing_x / modulus);
      Workspace workspace;
      std::vector<double> displacement(grid.size());
      kernel.displacement(pressure, displacement, workspace);
      const std::vector<float> step(pressure.begin(), pressure.end());
      std::vector<float> response(grid.size());
      kernel.displacement(step, response, workspace);
      for (std::size_t i = 0; i < grid.size(); ++i) {
        CHECK(std::abs(displacement[i] - expected[i]) <= round_off * unit);
        CHECK(std::abs(static_cast<double>(response[i]) - expected[i]) <= 5 * single_tolerance * unit);
      }
    }
  }
}

TEST_CASE("ElasticKernel: the stiffness is E*|k|/2 for each wave vector on periodic and free grids") {
  for (const bool periodic : {true, false}) {
    for (const Grid& grid : grids(periodic)) {
      const ElasticKernel kernel(grid, modulus);
      const std::vector<double> displacement = pseudo_random(grid.size());
      const std::vector<double> expected =
          filter_directly(grid, displacement, [](double k) { return 0.5 * modulus * k; });
      Workspace workspace;
      const std::vector<float> residual(displacement.begin(), displacement.end());
      std::vector<float> result(grid.size());
      kernel.apply_stiffness(residual, result, workspace);
      for (std::size_t i = 0; i < grid.size(); ++i) {
        CHECK(std::abs(static_cast<double>(result[i]) - expected[i]) <= single_tolerance * max_abs(expected));
      }
    }
  }
}

TEST_CASE(
    "ElasticKernel: results are bit-identical for any number of threads, and a cancellation check stops all threads") {
  const Grid grid{300, 280, 0.1, 0.1, false, false};
  const ElasticKernel kernel(grid, modulus);
  const std::vector<double> pressure = pseudo_random(grid.size());
  std::vector<double> alone(grid.size());
  Workspace workspace;
  kernel.displacement(pressure, alone, workspace);
  for (const std::size_t threads : {2U, 3U}) {
    const ThreadPool pool(threads);
    std::vector<double> together(grid.size());
    kernel.displacement(pressure, together, workspace, pool);
    CHECK(together == alone);
    CHECK(ElasticKernel(grid, modulus, pool).stencil() == kernel.stencil());
  }
  for (const std::size_t threads : {1U, 2U}) {
    const ThreadPool pool(threads, stiction::CancellationCheck([] { throw std::length_error("stop"); }));
    std::vector<double> displacement(grid.size());
    const auto go_on = [&] {
      for (int i = 0; i < 100; ++i) {
        kernel.displacement(pressure, displacement, workspace, pool);
      }
    };
    CHECK_THROWS_AS(go_on(), std::length_error);
  }
}

TEST_CASE("ThreadPool: rethrows the exception of a task and remains usable") {
  const ThreadPool pool(3);
  CHECK(pool.threads() == 3);
  const auto failing = [&] {
    pool.run(50, [](std::size_t task, std::size_t) {
      if (task == 33) {
        throw std::range_error("part");
      }
    });
  };
  CHECK_THROWS_AS(failing(), std::range_error);
  std::vector<int> done(50);
  pool.run(done.size(), [&](std::size_t task, std::size_t) { ++done[task]; });
  CHECK(std::count(done.begin(), done.end(), 1) == 50);
}

TEST_CASE("uniform_pressure_deviation: matches the computed displacements") {
  for (const Grid& grid : grids(false)) {
    const std::vector<double> displacement = displacement_directly(grid, std::vector<double>(grid.size(), 1.0));
    double mean = 0.0;
    double squares = 0.0;
    for (const double value : displacement) {
      mean += value / static_cast<double>(grid.size());
    }
    for (const double value : displacement) {
      squares += (value - mean) * (value - mean) / static_cast<double>(grid.size());
    }
    CHECK(stiction::uniform_pressure_deviation(grid, modulus) == doctest::Approx(std::sqrt(squares)).epsilon(1e-9));
  }
}

TEST_CASE("fast_length: returns known lengths, and invalid grids throw") {
  CHECK(stiction::fast_length(1) == 1);
  CHECK(stiction::fast_length(7) == 8);
  CHECK(stiction::fast_length(1999) == 2000);
  CHECK_THROWS_AS(ElasticKernel({1, 0, 1.0, 1.0, true, false}, modulus), std::invalid_argument);
  CHECK_THROWS_AS(ElasticKernel({2, 4, 1.0, 1.0, true, false}, modulus), std::invalid_argument);
  CHECK_THROWS_AS(ElasticKernel({1, 4, 1.0, 0.0, true, false}, modulus), std::invalid_argument);
  CHECK_THROWS_AS(ElasticKernel({1, 4, 1.0, 1.0, true, false}, std::nan("")), std::invalid_argument);
  const ElasticKernel kernel({1, 4, 1.0, 1.0, true, false}, modulus);
  Workspace workspace;
  std::vector<double> displacement(4);
  CHECK_THROWS_AS(kernel.displacement(std::vector<double>(5), displacement, workspace), std::invalid_argument);
}
