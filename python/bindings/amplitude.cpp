#include "stiction/amplitude.hpp"

#include "height_statistics.hpp"

namespace stiction::python {

py::array_t<double> to_array(const std::vector<HeightStatistics>& statistics) {
  py::array_t<double> array({static_cast<py::ssize_t>(statistics.size()), py::ssize_t{3}});
  double* row = array.mutable_data();
  for (const HeightStatistics& profile : statistics) {
    *row++ = profile.mean;
    *row++ = profile.min;
    *row++ = profile.max;
  }
  return array;
}

std::vector<HeightStatistics> to_height_statistics(const MatrixView& rows) {
  if (rows.cols() != 3) {
    throw py::value_error("statistics must have the columns mean, min and max");
  }
  std::vector<HeightStatistics> statistics;
  for (Index row = 0; row < rows.rows(); ++row) {
    statistics.push_back({rows(row, 0), rows(row, 1), rows(row, 2)});
  }
  return statistics;
}

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
      "Write heights of zero mean and the given amplitude [µm] to `scaled`. Returns False for a flat profile.");
}

}  // namespace stiction::python
