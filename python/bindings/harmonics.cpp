#include "stiction/harmonics.hpp"

#include "arrays.hpp"
#include "cancellation.hpp"
#include "height_statistics.hpp"

namespace stiction::python {

void bind_harmonics(py::module_& module) {
  module.def("frequency_weights", &frequency_weights, py::arg("hurst_exponent"), py::arg("frequencies"),
             py::arg("gamma"), py::arg("length_scale"), "Compute the amplitude [µm] of each frequency in Eq. 1.");
  module.def(
      "harmonic_profiles",
      [](const MatrixView& phases, const MatrixView& weights, Eigen::Ref<Matrix> profiles, double spacing,
         double length_scale, double gamma, bool band_limited) {
        const CancellationCheck check_cancellation = keyboard_interrupt_check();
        const std::vector<HeightStatistics> statistics = [&] {
          const py::gil_scoped_release release;
          return harmonic_profiles(phases, weights, {spacing, profiles.cols(), length_scale, gamma, band_limited},
                                   profiles, check_cancellation);
        }();
        return to_array(statistics);
      },
      py::arg("phases").noconvert(), py::arg("weights").noconvert(), py::arg("profiles").noconvert(), py::kw_only(),
      py::arg("spacing"), py::arg("length_scale"), py::arg("gamma"), py::arg("band_limited"),
      "Compute a profile by Eq. 1 for each row of weights, and write the heights [µm] to `profiles` (rows, points). "
      "Returns (mean, min, max) of each profile.");
  module.def(
      "harmonic_surface",
      [](const MatrixView& phases, const Array& weights, Eigen::Ref<Matrix> heights, double spacing_y, double spacing_x,
         double length_scale, double gamma, bool band_limited) {
        const Values frequency_weights_view = view(weights);
        const CancellationCheck check_cancellation = keyboard_interrupt_check();
        const py::gil_scoped_release release;
        harmonic_surface(phases, frequency_weights_view, {spacing_y, spacing_x, length_scale, gamma, band_limited},
                         heights, check_cancellation);
      },
      py::arg("phases").noconvert(), py::arg("weights").noconvert(), py::arg("heights").noconvert(), py::kw_only(),
      py::arg("spacing_y"), py::arg("spacing_x"), py::arg("length_scale"), py::arg("gamma"), py::arg("band_limited"),
      "Compute a height map by the areal form of Eq. 1, and write it to `heights` (rows, columns) [µm].");
}

}  // namespace stiction::python
