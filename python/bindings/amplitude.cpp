#include "stiction/amplitude.hpp"

#include "arrays.hpp"

namespace stiction::python {

void bind_amplitude(py::module_& module) {
  module.def(
      "scale_to_amplitude",
      [](const Array& heights, double amplitude, const std::string& measure, Array& scaled) {
        const Values values = view(heights);
        const std::span<double> out(scaled.mutable_data(), view(scaled).size());
        const py::gil_scoped_release release;
        return scale_to_amplitude(values, amplitude, amplitude_measure(measure), out);
      },
      py::arg("heights").noconvert(), py::arg("amplitude"), py::arg("measure"), py::arg("scaled").noconvert(),
      "Heights [µm] about a mean of zero with a measure of `amplitude` [µm], into `scaled`; False for a flat profile.");
}

}  // namespace stiction::python
