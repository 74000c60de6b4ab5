#include "stiction/contact.hpp"

#include "arrays.hpp"

namespace stiction::python {
namespace {

ContactModel model_of(const Law& law, bool by_cell, bool convex_only, int shear) {
  return {law, by_cell ? Detection::cell : Detection::gap_minimum, convex_only ? Curvature::convex : Curvature::any,
          shear};
}

// One array per column of a list of contacts.
template <class Field>
auto column(const std::vector<Contact>& rows, Field field) {
  std::vector<std::decay_t<decltype(field(rows.front()))>> values;
  values.reserve(rows.size());
  for (const Contact& row : rows) {
    values.push_back(field(row));
  }
  return array_from(std::move(values));
}

auto counts(const std::vector<Index>& values) {
  return array_from(std::vector<std::int64_t>(values.begin(), values.end()));
}

template <class Field>
Matrix vectors(const std::vector<Contact>& rows, Field field) {
  Matrix values(static_cast<Index>(rows.size()), 2);
  for (Index i = 0; i < values.rows(); ++i) {
    values.row(i) = field(rows[static_cast<std::size_t>(i)]);
  }
  return values;
}

}  // namespace

void bind_contact(py::module_& module) {
  module.def(
      "contacts",
      [](const Array& upper, const Array& lower, double spacing, double approach, const Law& law, bool by_cell,
         bool convex_only, int shear) {
        std::vector<Contact> rows;
        {
          const Values u = view(upper);
          const Values l = view(lower);
          const py::gil_scoped_release release;
          rows = contacts(u, l, spacing, approach, model_of(law, by_cell, convex_only, shear));
        }
        Table table;
        table["index"] = column(rows, [](const Contact& c) { return static_cast<std::int64_t>(c.index); });
        table["centre"] = vectors(rows, [](const Contact& c) { return c.centre; });
        table["normal"] = vectors(rows, [](const Contact& c) { return c.normal; });
        table["tangent"] = vectors(rows, [](const Contact& c) { return c.tangent; });
        table["radius"] = column(rows, [](const Contact& c) { return c.radius; });
        table["overlap"] = column(rows, [](const Contact& c) { return c.overlap; });
        table["force"] = column(rows, [](const Contact& c) { return c.force; });
        table["area"] = column(rows, [](const Contact& c) { return c.area; });
        table["opposing"] = column(rows, [](const Contact& c) { return static_cast<std::uint8_t>(c.opposing); });
        return table;
      },
      py::arg("upper").noconvert(), py::arg("lower").noconvert(), py::kw_only(), py::arg("spacing"),
      py::arg("approach"), py::arg("law"), py::arg("by_cell"), py::arg("convex_only"), py::arg("shear"),
      "Every contact at one approach [µm]: a dict of columns.");

  module.def(
      "press",
      [](const Array& upper, const Array& lower, const Array& approaches, double spacing, const Law& law, bool by_cell,
         bool convex_only, int shear) {
        LoadSums sums(0);
        {
          const Values u = view(upper);
          const Values l = view(lower);
          const Values a = view(approaches);
          const py::gil_scoped_release release;
          sums = press(u, l, spacing, a, model_of(law, by_cell, convex_only, shear));
        }
        Table table;
        table["contact_count"] = counts(sums.contact_count);
        table["contact_area"] = array_from(std::move(sums.contact_area));
        table["normal_elastic"] = array_from(std::move(sums.normal_elastic));
        table["tangential_elastic"] = array_from(std::move(sums.tangential_elastic));
        table["normal_frictional"] = array_from(std::move(sums.normal_frictional));
        table["tangential_frictional"] = array_from(std::move(sums.tangential_frictional));
        table["normal_adhesive"] = array_from(std::move(sums.normal_adhesive));
        table["tangential_adhesive"] = array_from(std::move(sums.tangential_adhesive));
        table["overlap_load"] = array_from(std::move(sums.overlap_load));
        table["load_beyond_hertz"] = array_from(std::move(sums.load_beyond_hertz));
        table["load_below_grid"] = array_from(std::move(sums.load_below_grid));
        table["crossed_count"] = counts(sums.crossed_count);
        return table;
      },
      py::arg("upper").noconvert(), py::arg("lower").noconvert(), py::arg("approaches").noconvert(), py::kw_only(),
      py::arg("spacing"), py::arg("law"), py::arg("by_cell"), py::arg("convex_only"), py::arg("shear"),
      "Sums over the contacts at each approach [µm]: a dict of columns.");
}

}  // namespace stiction::python
