#include "stiction/harmonics.hpp"

#include "arrays.hpp"
#include "checkpoint.hpp"
#include "levels.hpp"

namespace stiction::python {

void bind_harmonics(py::module_& module) {
  module.def("frequency_weights", &frequency_weights, py::arg("hurst_exponent"), py::arg("frequencies"),
             py::arg("gamma"), py::arg("length_scale"), "Amplitudes of the frequencies of Eq. 1 [µm].");
  module.def(
      "harmonic_profiles",
      [](const MatrixView& phases, const MatrixView& weights, Eigen::Ref<Matrix> profiles, double spacing,
         double length_scale, double gamma, bool band_limited) {
        const Checkpoint checkpoint = until_interrupted();
        const std::vector<Level> levels = [&] {
          const py::gil_scoped_release release;
          return harmonic_profiles(phases, weights, {spacing, profiles.cols(), length_scale, gamma, band_limited},
                                   profiles, checkpoint);
        }();
        return array_of(levels);
      },
      py::arg("phases").noconvert(), py::arg("weights").noconvert(), py::arg("profiles").noconvert(), py::kw_only(),
      py::arg("spacing"), py::arg("length_scale"), py::arg("gamma"), py::arg("band_limited"),
      "Eq. 1 for every row of weights, into `profiles` (rows, points) [µm]. Returns mean, lowest and highest of each.");
  module.def(
      "harmonic_surface",
      [](const MatrixView& phases, const Array& weights, Eigen::Ref<Matrix> heights, double spacing_y, double spacing_x,
         double length_scale, double gamma, bool band_limited) {
        const Values of_frequencies = view(weights);
        const Checkpoint checkpoint = until_interrupted();
        const py::gil_scoped_release release;
        harmonic_surface(phases, of_frequencies, {spacing_y, spacing_x, length_scale, gamma, band_limited}, heights,
                         checkpoint);
      },
      py::arg("phases").noconvert(), py::arg("weights").noconvert(), py::arg("heights").noconvert(), py::kw_only(),
      py::arg("spacing_y"), py::arg("spacing_x"), py::arg("length_scale"), py::arg("gamma"), py::arg("band_limited"),
      "Eq. 1 over an area, into `heights` (rows, columns) [µm].");
}

}  // namespace stiction::python
