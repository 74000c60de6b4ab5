// stiction._core: Python bindings of the C++ library, with one function per header.
#include <pybind11/pybind11.h>

namespace stiction::python {
void bind_amplitude(pybind11::module_& module);
void bind_areal(pybind11::module_& module);
void bind_profile_batch(pybind11::module_& module);
void bind_harmonics(pybind11::module_& module);
void bind_jackknife(pybind11::module_& module);
void bind_asperity(pybind11::module_& module);
void bind_bilinear(pybind11::module_& module);
void bind_law(pybind11::module_& module);
void bind_build(pybind11::module_& module);
void bind_candidates(pybind11::module_& module);
void bind_sums(pybind11::module_& module);
void bind_contact(pybind11::module_& module);
void bind_loading(pybind11::module_& module);
void bind_contact_statistics(pybind11::module_& module);
void bind_half_space(pybind11::module_& module);
void bind_energy_minimizer(pybind11::module_& module);
void bind_number_cells(pybind11::module_& module);
}  // namespace stiction::python

PYBIND11_MODULE(_core, module, pybind11::mod_gil_not_used()) {
  module.doc() =
      "C++ core of stiction. It accepts only exact types and array layouts; the Python package does all conversions.";
  module.attr("__version__") = STICTION_VERSION;
  stiction::python::bind_build(module);
  stiction::python::bind_amplitude(module);
  stiction::python::bind_harmonics(module);
  stiction::python::bind_jackknife(module);
  stiction::python::bind_asperity(module);
  stiction::python::bind_bilinear(module);
  stiction::python::bind_law(module);
  stiction::python::bind_candidates(module);
  stiction::python::bind_sums(module);
  stiction::python::bind_contact(module);
  stiction::python::bind_areal(module);
  stiction::python::bind_profile_batch(module);
  stiction::python::bind_loading(module);
  stiction::python::bind_half_space(module);
  stiction::python::bind_contact_statistics(module);
  stiction::python::bind_energy_minimizer(module);
  stiction::python::bind_number_cells(module);
}
