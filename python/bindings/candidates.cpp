#include "stiction/candidates.hpp"

#include "arrays.hpp"
#include "cancellation.hpp"

namespace stiction::python {

void bind_candidates(py::module_& module) {
  py::class_<Candidates>(module, "Candidates",
                         "Contact candidates of two profiles, valid for all approaches up to `deepest`.")
      .def("__len__", [](const Candidates& candidates) { return candidates.all.size(); })
      .def_readonly("deepest", &Candidates::deepest, "Largest approach [µm] for which the candidates are complete.")
      .def("columns", [](const Candidates& candidates) {
        Table table;
        table["index"] = column(candidates.all, [](const Candidate& c) { return static_cast<std::int64_t>(c.index); });
        table["position"] = column(candidates.all, [](const Candidate& c) { return c.position; });
        table["gap"] = column(candidates.all, [](const Candidate& c) { return c.gap; });
        table["radii"] =
            column(candidates.all, [](const Candidate& c) { return Vector2(c.radii.major, c.radii.minor); });
        return table;
      });

  module.def(
      "candidates",
      [](const Array& upper, const Array& lower, double spacing, double deepest, const std::string& allowed) {
        const ProfilePair pair{view(upper), view(lower), spacing};
        const CancellationCheck check_cancellation = keyboard_interrupt_check();
        const py::gil_scoped_release release;
        return candidates(pair, deepest, curvature(allowed), check_cancellation);
      },
      py::arg("upper").noconvert(), py::arg("lower").noconvert(), py::kw_only(), py::arg("spacing"), py::arg("deepest"),
      py::arg("curvature"),
      "Find the contact candidates of two profiles up to the approach `deepest` [µm]: the minima of the gap.");
}

}  // namespace stiction::python
