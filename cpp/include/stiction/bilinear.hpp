// Bilinear interpolation in a table of values.
#pragma once

#include "stiction/array.hpp"

#include <span>

namespace stiction {

/// Interpolate a table at pairs of fractional row and column indices, and write one value for each pair.
/// An index outside the table is replaced by the nearest index of the table. The value is NaN if an index is NaN.
/// Throws std::invalid_argument if the table has fewer than two rows or columns, or if arrays differ in length.
void interpolate_table(const MatrixView& table, Values rows, Values columns, std::span<double> values);

}  // namespace stiction
