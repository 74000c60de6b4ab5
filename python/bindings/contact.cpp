#include "contact.hpp"

#include "arrays.hpp"
#include "checkpoint.hpp"
#include "sums.hpp"

#include <array>

namespace stiction::python {

Table table_of(const std::vector<Contact>& rows) {
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

// What the library does while the GIL is free and Ctrl-C may end it.
template <class Work>
Table table_by(const Work& work) {
  const Checkpoint checkpoint = until_interrupted();
  auto rows = [&] {
    const py::gil_scoped_release release;
    return work(checkpoint);
  }();
  return table_of(rows);
}

}  // namespace

void bind_contact(py::module_& module) {
  py::class_<ContactModel>(module, "ContactModel", "How two bodies are pressed together.")
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
        return table_by([&](const Checkpoint& checkpoint) { return contacts(pair, approach, model, checkpoint); });
      },
      py::arg("upper").noconvert(), py::arg("lower").noconvert(), py::kw_only(), py::arg("spacing"),
      py::arg("approach"), py::arg("model"), "Every contact at one approach [µm]: a dict of columns.");
  module.def(
      "contacts",
      [](const Candidates& found, double approach, const ContactModel& model) {
        return table_by([&](const Checkpoint& checkpoint) { return contacts(found, approach, model, checkpoint); });
      },
      py::arg("found"), py::kw_only(), py::arg("approach"), py::arg("model"), "The same, of candidates.");

  module.def(
      "press",
      [](const Array& upper, const Array& lower, double spacing, const Array& approaches, const ContactModel& model) {
        const ProfilePair pair{view(upper), view(lower), spacing};
        const Values steps = view(approaches);
        return table_by([&](const Checkpoint& checkpoint) { return press(pair, steps, model, checkpoint); });
      },
      py::arg("upper").noconvert(), py::arg("lower").noconvert(), py::kw_only(), py::arg("spacing"),
      py::arg("approaches").noconvert(), py::arg("model"),
      "Sums over the contacts at each approach [µm]: a dict of columns.");
  module.def(
      "press",
      [](const Candidates& found, const Array& approaches, const ContactModel& model) {
        const Values steps = view(approaches);
        return table_by([&](const Checkpoint& checkpoint) { return press(found, steps, model, checkpoint); });
      },
      py::arg("found"), py::kw_only(), py::arg("approaches").noconvert(), py::arg("model"), "The same, of candidates.");
}

}  // namespace stiction::python
