// Bilinear interpolation in a table of values.
#pragma once

#include "stiction/array.hpp"

#include <span>

namespace stiction {

/// Interpolate a table at pairs of fractional row and column indices, linearly along rows and along columns.
/// Writes one value for each pair. Indices outside the table are moved to its edge.
/// The value is NaN if an index is NaN.
/// Throws std::invalid_argument if the table has fewer than two rows or columns, or if the numbers of rows, columns and
/// values differ.
void interpolate_table(const MatrixView& table, Values rows, Values columns, std::span<double> values);

}  // namespace stiction
