#include "stiction/law.hpp"

#include "arrays.hpp"

namespace stiction::python {

void bind_law(py::module_& module) {
  py::class_<HertzSphere>(module, "HertzSphere", "Elastic spheres: Hertz 1882.")
      .def(py::init<double>(), py::kw_only(), py::arg("effective_modulus"))
      .def_readonly("effective_modulus", &HertzSphere::effective_modulus, "E* [GPa]");
}

}  // namespace stiction::python
