// Displacements of a few points of an elastic half-space, from the matrix of their influence coefficients.
#pragma once

#include "stiction/elastic_kernel.hpp"
#include "stiction/values.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace stiction {

/// Displacements [µm] of selected grid points of an area due to pressures [GPa] on the selected points only.
/// The computing time increases with the square of the number of selected points, but does not depend on the grid size.
class DenseKernel {
 public:
  /// `influence` contains the displacement [µm/GPa] of each grid point due to a pressure on the first grid point.
  /// `influence` must outlive the DenseKernel. The constructor does not check whether all `points` are on the grid.
  /// Throws std::invalid_argument for 2³¹ grid points or more, or unless `influence` has one value per grid point.
  DenseKernel(Values influence, const Grid& grid, std::vector<std::size_t> points);

  /// Return, row by row, the symmetric matrix of the displacements due to unit pressures on the points [µm/GPa].
  template <class Real>
  std::vector<Real> matrix() const;

  /// Both arrays have one value per grid point. Values at grid points that are not selected are not read or changed.
  void displacement(Values pressure, std::span<double> displacements) const;

  void displacement(std::span<const float> pressure, std::span<float> displacements);

 private:
  template <class Real>
  void write_row(std::size_t i, Real* row) const;
  template <class Real, class Row>
  void add_rows(std::span<const Real> pressure, Row row, std::span<Real> displacements) const;

  Values influence_;
  std::size_t columns_;
  std::vector<std::size_t> points_;
  std::vector<std::int32_t> point_rows_;
  std::vector<std::int32_t> point_columns_;
  std::vector<float> matrix_;
};

}  // namespace stiction
