#include "stiction/amplitude.hpp"

#include "arrays.hpp"

namespace stiction::python {

void bind_amplitude(py::module_& module) {
  module.def(
      "scale_to_amplitude",
      [](const Array& heights, double amplitude, const std::string& measure) -> std::optional<Array> {
        const auto kind = measure == "height" ? AmplitudeMeasure::height
                          : measure == "Ra"   ? AmplitudeMeasure::mean_deviation
                                              : AmplitudeMeasure::rms_deviation;
        const Values values = view(heights);
        Array scaled(heights.size());
        const std::span<double> out(scaled.mutable_data(), values.size());
        bool possible = false;
        {
          const py::gil_scoped_release release;
          possible = scale_to_amplitude(values, amplitude, kind, out);
        }
        return possible ? std::optional(scaled) : std::nullopt;
      },
      py::arg("heights").noconvert(), py::arg("amplitude"), py::arg("measure"),
      "Heights [µm] about a mean of zero with a measure of `amplitude` [µm]; None for a flat profile.");
}

}  // namespace stiction::python
