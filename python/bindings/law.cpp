#include "stiction/law.hpp"

#include "arrays.hpp"

namespace stiction::python {

void bind_law(py::module_& module) {
  py::class_<HertzSphere>(module, "HertzSphere").def(py::init<double>(), py::kw_only(), py::arg("effective_modulus"));
  py::class_<HertzCylinder>(module, "HertzCylinder")
      .def(py::init<double, double>(), py::kw_only(), py::arg("effective_modulus"), py::arg("width"));
  py::class_<JacksonGreen>(module, "JacksonGreen")
      .def(py::init<double, double, double>(), py::kw_only(), py::arg("effective_modulus"), py::arg("yield_strength"),
           py::arg("poisson_ratio"));
  module.def("check", py::overload_cast<const Law&>(&check), py::arg("law"), "Raise a ValueError for a bad parameter.");
  module.def(
      "force_and_area",
      [](const Law& law, double overlap, double radius) {
        const ForceArea carried = std::visit([&](const auto& one) { return one(overlap, radius); }, law);
        return py::make_tuple(carried.force, carried.area);
      },
      py::arg("law"), py::arg("overlap"), py::arg("radius"), "Force [mN] and area [µm²] of one contact.");
}

}  // namespace stiction::python
