#include "stiction/asperity.hpp"

#include "arrays.hpp"

namespace stiction::python {

void bind_asperity(py::module_& module) {
  module.def(
      "asperities",
      [](const Array& heights, double spacing, const std::string& of) {
        Asperities all;
        {
          const Values values = view(heights);
          const py::gil_scoped_release release;
          all = asperities(values, spacing, side(of));
        }
        return py::make_tuple(to_array(std::move(all.slope)), to_array(std::move(all.curvature)),
                              to_array(std::move(all.normal)), to_array(std::move(all.radius)),
                              to_array(std::move(all.centre)));
      },
      py::arg("heights").noconvert(), py::kw_only(), py::arg("spacing"), py::arg("side"),
      "Compute slope, curvature [1/µm], normal, radius [µm] and centre [µm] at every point of a profile.");
}

}  // namespace stiction::python
