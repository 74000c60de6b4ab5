#include "stiction/number_cells.hpp"

#include "stiction/thread_pool.hpp"

#include "multiversion.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <system_error>

#if defined(_LIBCPP_VERSION) && _LIBCPP_VERSION < 200000
#define STICTION_USE_STRTOD 1  // LLVM's C++ library converts floating-point numbers only since version 20
#include <locale.h>
#include <cerrno>
#include <cstdlib>
#if defined(__APPLE__)
#include <xlocale.h>
#endif
#endif

namespace stiction {
namespace {

constexpr std::size_t chunk_length = std::size_t{1} << 18;  // characters that one task converts

// Each block has 255 characters, the largest count of an 8-bit counter, so that the compiler can vectorise the loop.
STICTION_MULTIVERSION
std::size_t count_cell_ends(const char* text, std::size_t size, char separator) {
  constexpr std::size_t block = 255;
  std::size_t count = 0;
  for (std::size_t first = 0; first < size; first += block) {
    std::uint8_t in_block = 0;
    const std::size_t end = std::min(first + block, size);
    for (std::size_t i = first; i < end; ++i) {
      in_block = static_cast<std::uint8_t>(in_block + ((text[i] == separator) | (text[i] == '\n')));
    }
    count += in_block;
  }
  return count;
}

// Convert the number at the start of `text`. Returns the end of the number, or null if `text` starts with no number.
const char* convert_number(std::string_view text, [[maybe_unused]] char separator, double& value) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') {
    text.remove_prefix(1);
  }
#if STICTION_USE_STRTOD
  static const locale_t locale = newlocale(LC_ALL_MASK, "C", nullptr);
  const std::string cell(text.substr(0, std::min(text.find(separator), text.find('\n'))));
  char* end = nullptr;
  errno = 0;
  value = strtod_l(cell.c_str(), &end, locale);
  const bool is_out_of_range = errno == ERANGE && (value == 0.0 || std::isinf(value));
  return is_out_of_range || cell.front() == ' ' || end == cell.c_str() ? nullptr : text.data() + (end - cell.c_str());
#else
  const std::from_chars_result result = std::from_chars(text.data(), text.data() + text.size(), value);
  return result.ec == std::errc{} ? result.ptr : nullptr;
#endif
}

}  // namespace

TextRows find_rows(std::string_view text, char separator) {
  TextRows rows;
  std::size_t start = 0;
  for (std::size_t end = text.find('\n'); end != std::string_view::npos; end = text.find('\n', start)) {
    rows.widths.push_back(static_cast<std::int64_t>(count_cell_ends(text.data() + start, end + 1 - start, separator)));
    start = end + 1;
    rows.starts.push_back(static_cast<std::int64_t>(start));
  }
  return rows;
}

std::vector<std::size_t> convert_cells(std::string_view text, char separator, std::span<double> values,
                                       std::size_t threads, const CancellationCheck& check_cancellation) {
  const auto is_cell_end = [&](char character) { return character == separator || character == '\n'; };
  const std::size_t chunks = (text.size() + chunk_length - 1) / chunk_length;
  const ThreadPool pool(std::clamp<std::size_t>(chunks, 1, std::max<std::size_t>(threads, 1)), check_cancellation);
  std::vector<std::size_t> first_cells(chunks + 1, 0);
  pool.run(chunks, [&](std::size_t chunk, std::size_t) {
    const std::string_view part = text.substr(chunk * chunk_length, chunk_length);
    first_cells[chunk + 1] = count_cell_ends(part.data(), part.size(), separator);
  });
  for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
    first_cells[chunk + 1] += first_cells[chunk];
  }
  const bool has_open_cell = !text.empty() && !is_cell_end(text.back());
  if (const std::size_t cells = first_cells[chunks] + (has_open_cell ? 1 : 0); cells != values.size()) {
    throw std::invalid_argument("text must have " + std::to_string(values.size()) + " cells, got " +
                                std::to_string(cells));
  }
  std::vector<std::vector<std::size_t>> failures(chunks);
  // Each cell is converted by the task whose chunk of text contains the end of the cell.
  pool.run(chunks, [&](std::size_t chunk, std::size_t) {
    const std::size_t end_cell = chunk + 1 < chunks ? first_cells[chunk + 1] : values.size();
    if (first_cells[chunk] == end_cell) {
      return;
    }
    const char* const end = text.data() + text.size();
    const char* start = text.data() + chunk * chunk_length;
    while (start != text.data() && !is_cell_end(start[-1])) {
      --start;
    }
    for (std::size_t cell = first_cells[chunk]; cell < end_cell; ++cell) {
      double value = std::numeric_limits<double>::quiet_NaN();
      const char* cell_end = start;
      if (!is_cell_end(*start)) {
        cell_end = convert_number({start, static_cast<std::size_t>(end - start)}, separator, value);
        if (cell_end == nullptr || (cell_end != end && !is_cell_end(*cell_end))) {
          failures[chunk].push_back(cell);
          value = std::numeric_limits<double>::quiet_NaN();
          cell_end = std::find_if(start, end, is_cell_end);
        }
      }
      values[cell] = value;
      start = cell_end + 1;
    }
  });
  std::vector<std::size_t> failed_cells;
  for (const std::vector<std::size_t>& cells : failures) {
    failed_cells.insert(failed_cells.end(), cells.begin(), cells.end());
  }
  return failed_cells;
}

}  // namespace stiction
