#include "stiction/harmonics.hpp"

#include "arrays.hpp"

namespace stiction::python {

void bind_harmonics(py::module_& module) {
  module.def("frequency_weights", &frequency_weights, py::arg("hurst_exponent"), py::arg("frequencies"),
             py::arg("gamma"), py::arg("length_scale"), "Amplitudes of the frequencies of Eq. 1 [µm].");
  module.def(
      "harmonic_profiles",
      [](const MatrixView& phases, const MatrixView& weights, Eigen::Ref<Matrix> profiles, double spacing,
         double length_scale, double gamma, bool band_limited) {
        harmonic_profiles(phases, weights, {spacing, profiles.cols(), length_scale, gamma, band_limited}, profiles);
      },
      py::arg("phases").noconvert(), py::arg("weights").noconvert(), py::arg("profiles").noconvert(), py::kw_only(),
      py::arg("spacing"), py::arg("length_scale"), py::arg("gamma"), py::arg("band_limited"),
      py::call_guard<py::gil_scoped_release>(), "Eq. 1 for every row of weights, into `profiles` (rows, points) [µm].");
}

}  // namespace stiction::python
