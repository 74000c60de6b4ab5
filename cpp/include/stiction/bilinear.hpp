// Bilinear interpolation in a table of numbers.
#pragma once

#include "stiction/array.hpp"

#include <span>

namespace stiction {

/// Interpolate a table at pairs of fractional row and column indices, and write one interpolated number for each pair.
/// An index outside the table is replaced by the nearest index of the table. If an index is NaN, the result is NaN.
/// Throws std::invalid_argument if the table has fewer than two rows or columns.
/// Throws std::invalid_argument if the arrays of row indices, column indices and results differ in length.
void interpolate_table(const MatrixView& table, Values rows, Values columns, std::span<double> values);

}  // namespace stiction
