// Division of a text into rows and cells, and conversion of the cells to numbers.
#pragma once

#include "stiction/cancellation.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace stiction {

struct TextRows {
  std::vector<std::int64_t> starts{0};  ///< offsets of the first character of each row, and of the end of the last row
  std::vector<std::int64_t> widths;
};

/// Find the rows of a text, and count the cells of each row. Characters after the last line feed are ignored.
TextRows find_rows(std::string_view text, char separator);

/// Convert the cells of a text to the nearest floating-point numbers, on up to `threads` threads.
/// Returns the indices of the cells that cannot be converted. These cells and empty cells become NaN.
/// Each cell ends at `separator`, at a line feed, or at the end of the text.
/// A cell can be converted if it contains "nan", "inf" or a decimal number in the range of a double.
/// The decimal mark is a point in every locale.
/// Throws std::invalid_argument if the text does not have `values.size()` cells.
std::vector<std::size_t> convert_cells(std::string_view text, char separator, std::span<double> values,
                                       std::size_t threads = 1, const CancellationCheck& check_cancellation = {});

}  // namespace stiction
