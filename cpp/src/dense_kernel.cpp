#include "stiction/dense_kernel.hpp"

#include "multiversion.hpp"

#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <utility>

namespace stiction {
namespace {

STICTION_MULTIVERSION
void add_scaled(const double* values, std::size_t size, double factor, double* sums) {
  for (std::size_t i = 0; i < size; ++i) {
    sums[i] += factor * values[i];
  }
}

STICTION_MULTIVERSION
void add_scaled(const float* values, std::size_t size, float factor, float* sums) {
  for (std::size_t i = 0; i < size; ++i) {
    sums[i] += factor * values[i];
  }
}

}  // namespace

DenseKernel::DenseKernel(Values influence, const Grid& grid, std::vector<std::size_t> points)
    : influence_(influence), columns_(grid.columns), points_(std::move(points)) {
  if (influence.size() != grid.size() ||
      grid.size() > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max())) {
    throw std::invalid_argument("DenseKernel: influence must have one value for each of fewer than 2^31 grid points");
  }
  for (const std::size_t point : points_) {
    point_rows_.push_back(static_cast<std::int32_t>(point / grid.columns));
    point_columns_.push_back(static_cast<std::int32_t>(point % grid.columns));
  }
}

template <class Real>
void DenseKernel::write_row(std::size_t i, Real* row) const {
  for (std::size_t j = 0; j < points_.size(); ++j) {
    const auto rows = static_cast<std::size_t>(std::abs(point_rows_[i] - point_rows_[j]));
    const auto columns = static_cast<std::size_t>(std::abs(point_columns_[i] - point_columns_[j]));
    row[j] = static_cast<Real>(influence_[rows * columns_ + columns]);
  }
}

template <class Real>
std::vector<Real> DenseKernel::matrix() const {
  std::vector<Real> matrix(points_.size() * points_.size());
  for (std::size_t i = 0; i < points_.size(); ++i) {
    write_row(i, matrix.data() + i * points_.size());
  }
  return matrix;
}

template std::vector<double> DenseKernel::matrix<double>() const;
template std::vector<float> DenseKernel::matrix<float>() const;

// The displacements are Σ pressure_i · (row i of the matrix), because the matrix is symmetric.
// Row i of the matrix is skipped if the pressure at point i is zero.
template <class Real, class Row>
void DenseKernel::add_rows(std::span<const Real> pressure, Row row, std::span<Real> displacements) const {
  std::vector<Real> sums(points_.size(), Real{0});
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (const Real value = pressure[points_[i]]; value != Real{0}) {
      add_scaled(row(i), points_.size(), value, sums.data());
    }
  }
  for (std::size_t i = 0; i < points_.size(); ++i) {
    displacements[points_[i]] = sums[i];
  }
}

void DenseKernel::displacement(Values pressure, std::span<double> displacements) const {
  std::vector<double> row(points_.size());
  const auto compute_row = [&](std::size_t i) {
    write_row(i, row.data());
    return row.data();
  };
  add_rows(pressure, compute_row, displacements);
}

void DenseKernel::displacement(std::span<const float> pressure, std::span<float> displacements) {
  if (matrix_.empty()) {
    matrix_ = matrix<float>();
  }
  add_rows(pressure, [&](std::size_t i) { return matrix_.data() + i * points_.size(); }, displacements);
}

}  // namespace stiction
