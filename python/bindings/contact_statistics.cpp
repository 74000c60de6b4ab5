#include "stiction/contact_statistics.hpp"

#include "arrays.hpp"
#include "patches.hpp"

#include <cstdint>

namespace stiction::python {
namespace {

using Marks = py::array_t<bool, py::array::c_style>;

// Return the quantiles of k contacts as an array of shape (k, probabilities).
py::array_t<double> by_probability(const std::vector<ContactStatistics>& rows,
                                   std::vector<double> ContactStatistics::* field) {
  std::vector<double> values;
  for (const ContactStatistics& row : rows) {
    values.insert(values.end(), (row.*field).begin(), (row.*field).end());
  }
  return to_array(std::move(values)).reshape({static_cast<py::ssize_t>(rows.size()), py::ssize_t{-1}});
}

Table to_table(const std::vector<ContactStatistics>& rows) {
  Table table;
  table["share_on_largest"] = column(rows, [](const auto& row) { return row.fraction_on_largest; });
  table["share_at_edge"] = column(rows, [](const auto& row) { return row.fraction_at_edge; });
  table["fraction_on_small"] = column(rows, [](const auto& row) { return row.fraction_on_small; });
  table["patch_area"] = by_probability(rows, &ContactStatistics::area_quantiles);
  table["pressure"] = by_probability(rows, &ContactStatistics::pressure_quantiles);
  return table;
}

}  // namespace

void bind_contact_statistics(py::module_& module) {
  module.def(
      "contact_statistics",
      [](const Array& force, const Array& area, const Array& cells, const Marks& at_edge, const Array& pressure,
         const Array& weight, const Array& probabilities, double max_small_cells) {
        const ContactTable table{view(force), view(area), view(cells), grid(at_edge), view(pressure), view(weight)};
        return to_table({contact_statistics(table, view(probabilities), max_small_cells)});
      },
      py::arg("force").noconvert(), py::arg("area").noconvert(), py::arg("cells").noconvert(),
      py::arg("at_edge").noconvert(), py::arg("pressure").noconvert(), py::arg("weight").noconvert(), py::kw_only(),
      py::arg("probabilities").noconvert(), py::arg("max_small_cells"),
      "Compute load fractions, and quantiles of area and pressure, of the contacts at one load.");
  module.def(
      "patch_statistics",
      [](const std::vector<Contact>& contacts, const std::vector<std::size_t>& shape,
         const std::vector<double>& spacing, const Array& probabilities, double max_small_cells) {
        const std::vector<ContactView> views = to_views(contacts);
        const Grid contact_grid = grid_of(shape, spacing, false);
        const Values of = view(probabilities);
        std::vector<ContactStatistics> rows;
        {
          const py::gil_scoped_release release;
          for (const ContactView& contact : views) {
            rows.push_back(patch_statistics(contact, contact_grid, of, max_small_cells));
          }
        }
        return to_table(rows);
      },
      py::arg("contacts").noconvert(), py::kw_only(), py::arg("shape"), py::arg("spacing"),
      py::arg("probabilities").noconvert(), py::arg("max_small_cells"),
      "Compute load fractions, and quantiles of area and pressure, of the patches of several half-space contacts. Each "
      "contact is a tuple of arrays as from `patches_of`.");
  module.def(
      "load_fractions_on_marked_points",
      [](const std::vector<Contact>& contacts, const Marks& marks) {
        std::vector<double> fractions;
        for (const ContactView& contact : to_views(contacts)) {
          fractions.push_back(load_fraction_on_marked_points(contact, grid(marks)));
        }
        return to_array(std::move(fractions));
      },
      py::arg("contacts").noconvert(), py::arg("marks").noconvert(),
      "Return the load fraction on marked grid points of several half-space contacts.");
}

}  // namespace stiction::python
