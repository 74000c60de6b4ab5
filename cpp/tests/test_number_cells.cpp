#include "stiction/number_cells.hpp"

#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using Indices = std::vector<std::size_t>;

TEST_CASE("rows end at line feeds, and an empty row has one cell") {
  const stiction::TextRows rows = stiction::find_rows("1;2;3\n\n;\n4", ';');
  CHECK(rows.starts == std::vector<std::int64_t>{0, 6, 7, 9});
  CHECK(rows.widths == std::vector<std::int64_t>{3, 1, 2});
}

TEST_CASE("a text without line feeds has no rows") {
  CHECK(stiction::find_rows("", ';').starts == std::vector<std::int64_t>{0});
  CHECK(stiction::find_rows("1;2", ';').widths.empty());
}

TEST_CASE("a row can have more cells than a byte can count") {
  std::string text(70'000, '\t');
  text += "\n1\t2\n";
  CHECK(stiction::find_rows(text, '\t').widths == std::vector<std::int64_t>{70'001, 2});
}

TEST_CASE("cells end at separators and line feeds, and empty cells are NaN") {
  std::vector<double> values(6);
  CHECK(stiction::convert_cells("1;-2.5\n+3e2;\n;nan\n", ';', values).empty());
  CHECK(values[0] == 1.0);
  CHECK(values[1] == -2.5);
  CHECK(values[2] == 300.0);
  for (const std::size_t empty : Indices{3, 4, 5}) {
    CHECK(std::isnan(values[empty]));
  }
}

TEST_CASE("the end of the text ends its last cell") {
  std::vector<double> values(2);
  CHECK(stiction::convert_cells("1\n22", '\t', values).empty());
  CHECK(values[1] == 22.0);
}

TEST_CASE("a text without characters has no cells") { CHECK(stiction::convert_cells("", '\t', {}).empty()); }

TEST_CASE("cells without a number in the range of double are reported as failed") {
  std::vector<double> values(9);
  const Indices failed = stiction::convert_cells("1.2.3\t4\n1e400\t+-5\t1e\t--\t 6\t7 \t-.5\n", '\t', values);
  CHECK(failed == Indices{0, 2, 3, 4, 5, 6, 7});
  CHECK(values[8] == -0.5);
}

TEST_CASE("a text with more or fewer cells than requested values is rejected") {
  std::vector<double> values(2);
  CHECK_THROWS_AS(stiction::convert_cells("1\t2\t3\n", '\t', values), std::invalid_argument);
  CHECK_THROWS_AS(stiction::convert_cells("1\n", '\t', values), std::invalid_argument);
}

TEST_CASE("numbers of any length are the nearest doubles for any number of threads") {
  std::mt19937_64 random(7);
  std::string text;
  std::vector<double> expected;
  Indices not_numbers;
  while (text.size() < 2'000'000) {  // the text is converted in several chunks
    const std::uint64_t kind = random() % 64;
    std::string cell;
    if (kind == 0) {
      cell.assign(1, 'x');
      not_numbers.push_back(expected.size());
    } else if (kind > 1) {
      const double value = kind % 2 == 0 ? std::bit_cast<double>(random()) : 1e-18 * static_cast<double>(random());
      std::vector<char> buffer(64);
      const int length = std::snprintf(buffer.data(), buffer.size(), "%.*g", static_cast<int>(kind % 20), value);
      cell.assign(buffer.data(), static_cast<std::size_t>(length));
      if (std::isinf(std::strtod(cell.c_str(), nullptr)) || std::isnan(value)) {
        cell.assign(1, '0');  // rounding to fewer digits can exceed the range of a double
      }
    }
    expected.push_back(kind > 1 ? std::strtod(cell.c_str(), nullptr) : std::numeric_limits<double>::quiet_NaN());
    text += cell + (random() % 16 == 0 ? '\n' : '\t');
  }
  for (const std::size_t threads : Indices{1, 2, 3}) {
    std::vector<double> values(expected.size());
    CHECK(stiction::convert_cells(text, '\t', values, threads) == not_numbers);
    std::size_t differences = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const bool both_nan = std::isnan(values[i]) && std::isnan(expected[i]);
      differences += !both_nan && std::bit_cast<std::uint64_t>(values[i]) != std::bit_cast<std::uint64_t>(expected[i]);
    }
    CHECK(differences == 0);
  }
}

TEST_CASE("a cell may be longer than several chunks") {
  const std::string text = "5\n" + std::string(1'000'000, '0') + "7\n8\n";
  std::vector<double> values(3);
  CHECK(stiction::convert_cells(text, '\t', values, 2).empty());
  CHECK(values == std::vector<double>{5.0, 7.0, 8.0});
}

}  // namespace
