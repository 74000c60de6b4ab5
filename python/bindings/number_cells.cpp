#include "stiction/number_cells.hpp"

#include "arrays.hpp"
#include "cancellation.hpp"

#include <utility>

namespace stiction::python {

void bind_number_cells(py::module_& module) {
  module.def(
      "find_rows",
      [](const py::bytes& text, char separator) {
        TextRows rows = find_rows(static_cast<std::string_view>(text), separator);
        return std::pair(to_array(std::move(rows.starts)), to_array(std::move(rows.widths)));
      },
      py::arg("text"), py::arg("separator"),
      "Find the rows of a text. Returns the offsets at which rows start and the last row ends, and the number of cells "
      "in each row.");
  module.def(
      "convert_cells",
      [](const py::bytes& text, char separator, Array& values, std::size_t threads) {
        const std::span<double> out(values.mutable_data(), view(values).size());
        const auto characters = static_cast<std::string_view>(text);
        const CancellationCheck check_cancellation = keyboard_interrupt_check();
        const py::gil_scoped_release release;
        return convert_cells(characters, separator, out, threads, check_cancellation);
      },
      py::arg("text"), py::arg("separator"), py::arg("values").noconvert(), py::kw_only(), py::arg("threads") = 1,
      "Parse the cells of a text as numbers, and write the numbers to `values`. Returns the indices of the cells that "
      "are not numbers.");
}

}  // namespace stiction::python
