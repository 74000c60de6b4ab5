#include "stiction/law.hpp"

#include "arrays.hpp"

namespace stiction::python {

void bind_law(py::module_& module) {
  module.def(
      "force_and_area",
      [](const std::string& name, const std::map<std::string, double>& parameters, double overlap, double radius) {
        const auto carried_by = [&](const auto& one) { return one(overlap, Radii{radius, radius}); };
        const ForceArea carried = std::visit(carried_by, law(name, parameters));
        return py::make_tuple(carried.force, carried.area);
      },
      py::arg("law"), py::arg("parameters"), py::kw_only(), py::arg("overlap"), py::arg("radius"),
      "Force [mN] and area [µm²] of one contact, by a law of this name with all of its parameters.");
}

}  // namespace stiction::python
