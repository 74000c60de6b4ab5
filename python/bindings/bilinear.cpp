#include "stiction/bilinear.hpp"

#include "arrays.hpp"

namespace stiction::python {

void bind_bilinear(py::module_& module) {
  module.def(
      "interpolate_table",
      [](const MatrixView& table, const Array& rows, const Array& columns) {
        const Values row_indices = view(rows);
        const Values column_indices = view(columns);
        py::array_t<double> values(rows.size());
        const std::span<double> out(values.mutable_data(), row_indices.size());
        {
          const py::gil_scoped_release release;
          interpolate_table(table, row_indices, column_indices, out);
        }
        return values;
      },
      py::arg("table").noconvert(), py::arg("rows").noconvert(), py::arg("columns").noconvert(),
      "Interpolate a table linearly at pairs of fractional row and column indices. Indices outside the table are moved "
      "to its edge. The value is NaN if an index is NaN.");
}

}  // namespace stiction::python
