#include "stiction/dense_kernel.hpp"

#include "stiction/half_space.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <vector>

using stiction::DenseKernel;
using stiction::Grid;
using stiction::HalfSpaceGrids;

TEST_CASE("DenseKernel: displacements of a few points equal those of the elastic kernel") {
  const HalfSpaceGrids grids(Grid{17, 24, 0.05, 0.04, false, false}, 10.0);
  const std::size_t size = 17 * 24;
  const std::vector<std::size_t> points{0, 1, 23, 100, 101, 125, 300, size - 1};
  std::vector<double> pressure(size, 0.0);
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {  // the last point has no pressure
    pressure[points[i]] = 0.1 + 0.05 * static_cast<double>(i);
  }
  stiction::Workspace workspace;
  std::vector<double> expected(size);
  grids.kernels().points->displacement(pressure, expected, workspace);

  DenseKernel kernel(grids.influence(), grids.levels()[0], points);
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> displacement(size, unknown);
  kernel.displacement(pressure, displacement);
  const std::vector<float> single(pressure.begin(), pressure.end());
  std::vector<float> single_displacement(size, 7.0F);
  for (int call = 0; call < 2; ++call) {  // the second call reuses the matrix
    kernel.displacement(single, single_displacement);
  }
  for (std::size_t i = 0; i < size; ++i) {
    if (std::find(points.begin(), points.end(), i) != points.end()) {
      CHECK(displacement[i] == doctest::Approx(expected[i]).epsilon(1e-13));
      CHECK(single_displacement[i] == doctest::Approx(expected[i]).epsilon(1e-6));
    } else {
      CHECK(displacement[i] != displacement[i]);
      CHECK(single_displacement[i] == 7.0F);
    }
  }
  const std::vector<double> matrix = kernel.matrix<double>();
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = 0; j < points.size(); ++j) {
      CHECK(matrix[i * points.size() + j] == matrix[j * points.size() + i]);
    }
  }
}

TEST_CASE("DenseKernel: rejects influence coefficients of another grid") {
  const std::vector<double> influence(12, 1.0);
  CHECK_THROWS_AS(DenseKernel(influence, Grid{3, 5, 0.1, 0.1, false, false}, {0}), std::invalid_argument);
}
