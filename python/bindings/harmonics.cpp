#include "stiction/harmonics.hpp"

#include "arrays.hpp"

namespace stiction::python {

void bind_harmonics(py::module_& module) {
  module.def("frequency_weights", &frequency_weights, py::arg("hurst_exponent"), py::arg("frequencies"),
             py::arg("gamma"), py::arg("length_scale"), "Amplitudes of the frequencies of Eq. 1 [µm].");
  module.def(
      "harmonic_profiles",
      [](const MatrixView& phases, const MatrixView& weights, double spacing, Index points, double length_scale,
         double gamma, bool band_limited) {
        // NumPy's memory, which comes in large pages where the system has them.
        py::array_t<double> profiles({weights.rows(), std::max<Index>(points, 0)});
        Eigen::Map<Matrix> view(profiles.mutable_data(), profiles.shape(0), profiles.shape(1));
        const py::gil_scoped_release release;
        harmonic_profiles(phases, weights, {spacing, points, length_scale, gamma, band_limited}, view);
        return profiles;
      },
      py::arg("phases").noconvert(), py::arg("weights").noconvert(), py::kw_only(), py::arg("spacing"),
      py::arg("points"), py::arg("length_scale"), py::arg("gamma"), py::arg("band_limited"),
      "Eq. 1 for every row of weights: (rows, points) heights [µm].");
}

}  // namespace stiction::python
