#include "contact.hpp"

#include "arrays.hpp"
#include "cancellation.hpp"
#include "sums.hpp"

#include <array>

namespace stiction::python {

Table to_table(const std::vector<Contact>& rows) {
  Table table;
  table["index"] = column(rows, [](const Contact& c) { return static_cast<std::int64_t>(c.index); });
  table["centre"] = column(rows, [](const Contact& c) { return c.centre; });
  table["normal"] = column(rows, [](const Contact& c) { return c.normal; });
  table["tangent"] = column(rows, [](const Contact& c) { return c.tangent; });
  table["radii"] = column(rows, [](const Contact& c) { return Vector2(c.radii.major, c.radii.minor); });
  table["radius"] = column(rows, [](const Contact& c) { return c.radii.mean(); });
  table["axes"] = column(rows, [](const Contact& c) { return c.axes; });
  table["along"] = column(rows, [](const Contact& c) { return c.along; });
  table["overlap"] = column(rows, [](const Contact& c) { return c.overlap; });
  table["force"] = column(rows, [](const Contact& c) { return c.force; });
  table["area"] = column(rows, [](const Contact& c) { return c.area; });
  table["opposing"] = column(rows, [](const Contact& c) { return static_cast<std::uint8_t>(c.opposing); });
  return table;
}

namespace {

// Run `work` without the GIL, so that Ctrl-C can cancel the work, and return the result as a table.
template <class Work>
Table table_of_results(const Work& work) {
  const CancellationCheck check_cancellation = keyboard_interrupt_check();
  auto rows = [&] {
    const py::gil_scoped_release release;
    return work(check_cancellation);
  }();
  return to_table(rows);
}

}  // namespace

void bind_contact(py::module_& module) {
  py::class_<ContactModel>(module, "ContactModel",
                           "Contact law, detection method and sliding rule for a pair of surfaces.")
      .def(py::init([](const std::string& name, const std::map<std::string, double>& parameters,
                       const std::string& where, const std::string& allowed, const std::array<double, 2>& direction,
                       const std::string& rule) {
             return ContactModel{law(name, parameters), detection(where), curvature(allowed),
                                 Vector2(direction[0], direction[1]), sliding(rule)};
           }),
           py::kw_only(), py::arg("law"), py::arg("parameters"), py::arg("detection"), py::arg("curvature"),
           py::arg("direction"), py::arg("sliding"));

  module.def(
      "contacts",
      [](const Array& upper, const Array& lower, double spacing, double approach, const ContactModel& model) {
        const ProfilePair pair{view(upper), view(lower), spacing};
        return table_of_results([&](const CancellationCheck& check_cancellation) {
          return contacts(pair, approach, model, check_cancellation);
        });
      },
      py::arg("upper").noconvert(), py::arg("lower").noconvert(), py::kw_only(), py::arg("spacing"),
      py::arg("approach"), py::arg("model"),
      "List the contacts of two profiles at one approach [µm], as a dict of columns.");
  module.def(
      "contacts",
      [](const Candidates& candidates, double approach, const ContactModel& model) {
        return table_of_results([&](const CancellationCheck& check_cancellation) {
          return contacts(candidates, approach, model, check_cancellation);
        });
      },
      py::arg("candidates"), py::kw_only(), py::arg("approach"), py::arg("model"),
      "List the contacts of stored candidates at one approach [µm], as a dict of columns.");

  module.def(
      "press",
      [](const Array& upper, const Array& lower, double spacing, const Array& approaches, const ContactModel& model) {
        const ProfilePair pair{view(upper), view(lower), spacing};
        const Values steps = view(approaches);
        return table_of_results(
            [&](const CancellationCheck& check_cancellation) { return press(pair, steps, model, check_cancellation); });
      },
      py::arg("upper").noconvert(), py::arg("lower").noconvert(), py::kw_only(), py::arg("spacing"),
      py::arg("approaches").noconvert(), py::arg("model"),
      "Compute the contact sums of two profiles at each approach [µm], as a dict of columns.");
  module.def(
      "press",
      [](const Candidates& candidates, const Array& approaches, const ContactModel& model) {
        const Values steps = view(approaches);
        return table_of_results([&](const CancellationCheck& check_cancellation) {
          return press(candidates, steps, model, check_cancellation);
        });
      },
      py::arg("candidates"), py::kw_only(), py::arg("approaches").noconvert(), py::arg("model"),
      "Compute the contact sums of stored candidates at each approach [µm], as a dict of columns.");
}

}  // namespace stiction::python
