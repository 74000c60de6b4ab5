#include "stiction/amplitude.hpp"

#include "levels.hpp"

namespace stiction::python {

py::array_t<double> array_of(const std::vector<Level>& levels) {
  py::array_t<double> array({static_cast<py::ssize_t>(levels.size()), py::ssize_t{3}});
  double* row = array.mutable_data();
  for (const Level& level : levels) {
    *row++ = level.mean;
    *row++ = level.lowest;
    *row++ = level.highest;
  }
  return array;
}

std::vector<Level> levels_of(const MatrixView& rows) {
  if (rows.cols() != 3) {
    throw py::value_error("levels must be mean, lowest and highest of each profile");
  }
  std::vector<Level> levels;
  for (Index row = 0; row < rows.rows(); ++row) {
    levels.push_back({rows(row, 0), rows(row, 1), rows(row, 2)});
  }
  return levels;
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
      "Heights [µm] about a mean of zero with a measure of `amplitude` [µm], into `scaled`; False for a flat profile.");
}

}  // namespace stiction::python
