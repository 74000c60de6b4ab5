#include "stiction/bilinear.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>

namespace stiction {
namespace {

struct Neighbours {
  Index before;
  double weight_before;
  double weight_after;
};

Neighbours find_neighbours(double index, Index size) {
  const double limited = std::clamp(index, 0.0, static_cast<double>(size - 1));
  const Index before = std::min(static_cast<Index>(limited), size - 2);
  const double weight_after = limited - static_cast<double>(before);
  return {before, 1.0 - weight_after, weight_after};
}

}  // namespace

void interpolate_table(const MatrixView& table, Values rows, Values columns, std::span<double> values) {
  if (table.rows() < 2 || table.cols() < 2) {
    throw std::invalid_argument("interpolate_table: the table must have at least two rows and two columns");
  }
  if (rows.size() != values.size() || columns.size() != values.size()) {
    throw std::invalid_argument("interpolate_table: rows, columns and values must have the same length");
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isnan(rows[i]) || std::isnan(columns[i])) {
      values[i] = std::numeric_limits<double>::quiet_NaN();
      continue;
    }
    const Neighbours row = find_neighbours(rows[i], table.rows());
    const Neighbours column = find_neighbours(columns[i], table.cols());
    const double* upper = table.data() + row.before * table.outerStride() + column.before;
    const double* lower = upper + table.outerStride();
    values[i] = upper[0] * row.weight_before * column.weight_before +
                upper[1] * row.weight_before * column.weight_after +
                lower[0] * row.weight_after * column.weight_before + lower[1] * row.weight_after * column.weight_after;
  }
}

}  // namespace stiction
