#include "stiction/law.hpp"

#include "arrays.hpp"

namespace stiction::python {

void bind_law(py::module_& module) {
  module.def(
      "force_and_area",
      [](const std::string& name, const std::map<std::string, double>& parameters, double overlap, double radius) {
        const auto apply = [&](const auto& any_law) { return any_law(overlap, Radii{radius, radius}); };
        const ForceArea force_area = std::visit(apply, law(name, parameters));
        return py::make_tuple(force_area.force, force_area.area);
      },
      py::arg("law"), py::arg("parameters"), py::kw_only(), py::arg("overlap"), py::arg("radius"),
      "Compute force [mN] and area [µm²] of one contact for a named law with all of its parameters.");
}

}  // namespace stiction::python
