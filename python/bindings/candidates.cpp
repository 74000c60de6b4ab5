#include "stiction/candidates.hpp"

#include "arrays.hpp"
#include "checkpoint.hpp"

namespace stiction::python {

void bind_candidates(py::module_& module) {
  py::class_<Candidates>(module, "Candidates",
                         "Places where two bodies may touch, found once for any number of presses.")
      .def("__len__", [](const Candidates& found) { return found.all.size(); })
      .def_readonly("deepest", &Candidates::deepest, "Approach [µm] up to which they were looked for.")
      .def("columns", [](const Candidates& found) {
        Table table;
        table["index"] = column(found.all, [](const Candidate& c) { return static_cast<std::int64_t>(c.index); });
        table["position"] = column(found.all, [](const Candidate& c) { return c.position; });
        table["gap"] = column(found.all, [](const Candidate& c) { return c.gap; });
        table["radii"] = column(found.all, [](const Candidate& c) { return Vector2(c.radii.major, c.radii.minor); });
        return table;
      });

  module.def(
      "candidates",
      [](const Array& upper, const Array& lower, double spacing, double deepest, const std::string& allowed) {
        const ProfilePair pair{view(upper), view(lower), spacing};
        const Checkpoint checkpoint = until_interrupted();
        const py::gil_scoped_release release;
        return candidates(pair, deepest, curvature(allowed), checkpoint);
      },
      py::arg("upper").noconvert(), py::arg("lower").noconvert(), py::kw_only(), py::arg("spacing"), py::arg("deepest"),
      py::arg("curvature"), "The gap minima of two profiles up to a deepest approach [µm].");
}

}  // namespace stiction::python
