#include "stiction/areal.hpp"
#include "stiction/bicubic.hpp"
#include "stiction/periodic_slopes.hpp"

#include "arrays.hpp"
#include "cancellation.hpp"
#include "contact.hpp"
#include "sums.hpp"

#include <array>

namespace stiction::python {
namespace {

// The conversion of pybind11 to an Eigen reference would silently copy non-contiguous arrays.
Eigen::Map<const Matrix> to_map(const Array& array) {
  if (array.ndim() != 2) {
    throw py::value_error("expected an array of 2 dimensions, got " + std::to_string(array.ndim()));
  }
  return {array.data(), array.shape(0), array.shape(1)};
}

std::vector<Vector2> to_directions(const Array& array) {
  const Eigen::Map<const Matrix> rows = to_map(array);
  if (rows.cols() != 2) {
    throw py::value_error("expected directions of 2 components, got " + std::to_string(rows.cols()));
  }
  std::vector<Vector2> directions;
  for (Index i = 0; i < rows.rows(); ++i) {
    directions.emplace_back(rows(i, 0), rows(i, 1));
  }
  return directions;
}

// Return the slopes (dz/dy, dz/dx) that `compute` writes for a map.
template <class Compute>
std::array<py::array_t<double>, 2> compute_slopes(const Compute& compute, const Array& heights,
                                                  const std::array<double, 2>& spacing) {
  const Eigen::Map<const Matrix> map = to_map(heights);
  const std::array<py::ssize_t, 2> shape{map.rows(), map.cols()};
  std::array<py::array_t<double>, 2> slopes{py::array_t<double>(shape), py::array_t<double>(shape)};
  const auto to_output = [&](std::size_t axis) {
    return Eigen::Map<Matrix>(slopes[axis].mutable_data(), map.rows(), map.cols());
  };
  auto slopes_y = to_output(0);
  auto slopes_x = to_output(1);
  {
    const py::gil_scoped_release release;
    compute(map, Vector2(spacing[1], spacing[0]), slopes_x, slopes_y);
  }
  return slopes;
}

Table to_areal_table(const std::vector<ArealSums>& rows) {
  Table table = to_table(std::vector<Sums>(rows.begin(), rows.end()));
  for (const ArealQuantity& quantity : areal_quantities) {
    const auto column_of = [&](auto member) -> py::array {
      using Value = std::conditional_t<std::is_same_v<decltype(member), Index ArealSums::*>, std::int64_t, double>;
      return column(rows, [&](const ArealSums& sums) { return static_cast<Value>(sums.*member); });
    };
    table[py::str(quantity.name.data(), quantity.name.size())] = std::visit(column_of, quantity.member);
  }
  return table;
}

}  // namespace

void bind_areal(py::module_& module) {
  py::class_<ArealCandidates>(module, "ArealCandidates",
                              "Contact candidates of two maps, valid for all approaches up to `deepest`.")
      .def("__len__", [](const ArealCandidates& candidates) { return candidates.all.size(); })
      .def_readonly("deepest", &ArealCandidates::deepest,
                    "Largest approach [µm] for which the candidates are complete.")
      .def("columns", [](const ArealCandidates& candidates) {
        Table table;
        const auto cell = [&](const ArealCandidate& c) {
          return static_cast<std::int64_t>(c.row * candidates.columns + c.column);
        };
        table["index"] = column(candidates.all, cell);
        table["position"] = column(candidates.all, [](const ArealCandidate& c) { return c.position; });
        table["gap"] = column(candidates.all, [](const ArealCandidate& c) { return c.gap; });
        table["radii"] =
            column(candidates.all, [](const ArealCandidate& c) { return Vector2(c.radii.major, c.radii.minor); });
        return table;
      });

  module.def(
      "areal_quantities",
      [] {
        std::vector<std::tuple<std::string, std::string, std::string>> all;
        for (const ArealQuantity& quantity : areal_quantities) {
          all.emplace_back(quantity.name, quantity.unit, quantity.description);
        }
        return all;
      },
      "Return name, unit and description of the contact sums that exist only for areal contact.");
  module.def(
      "candidates",
      [](const Array& upper, const Array& lower, const std::array<double, 2>& spacing, double deepest,
         const std::string& allowed) {
        const Eigen::Map<const Matrix> above = to_map(upper);
        const Eigen::Map<const Matrix> below = to_map(lower);
        const CancellationCheck check_cancellation = keyboard_interrupt_check();
        const py::gil_scoped_release release;
        const SurfacePair pair{above, below, Vector2(spacing[1], spacing[0])};
        return candidates(pair, deepest, curvature(allowed), check_cancellation);
      },
      py::arg("upper").noconvert(), py::arg("lower").noconvert(), py::kw_only(), py::arg("spacing"), py::arg("deepest"),
      py::arg("curvature"),
      "Find the contact candidates of two maps up to the approach `deepest` [µm]: the minima of the gap. "
      "`spacing` is (Δy, Δx) [µm].");
  module.def(
      "natural_slopes",
      [](const Array& heights, const std::array<double, 2>& spacing) {
        return compute_slopes(natural_slopes, heights, spacing);
      },
      py::arg("heights").noconvert(), py::kw_only(), py::arg("spacing"),
      "Compute the slopes (dz/dy, dz/dx) of a map from natural cubic splines. `spacing` is (Δy, Δx) [µm].");
  module.def(
      "periodic_slopes",
      [](const Array& heights, const std::array<double, 2>& spacing) {
        return compute_slopes(periodic_slopes, heights, spacing);
      },
      py::arg("heights").noconvert(), py::kw_only(), py::arg("spacing"),
      "Compute the slopes (dz/dy, dz/dx) of a periodic map from Fourier transforms. `spacing` is (Δy, Δx) [µm].");
  module.def(
      "contacts",
      [](const ArealCandidates& candidates, double approach, const ContactModel& model) {
        const auto rows = [&] {
          const py::gil_scoped_release release;
          return contacts(candidates, approach, model.law, model.direction);
        }();
        return to_table(rows);
      },
      py::arg("candidates"), py::kw_only(), py::arg("approach"), py::arg("model"),
      "List the contacts of two maps at one approach [µm], as a dict of columns.");
  module.def(
      "press",
      [](const ArealCandidates& candidates, const Array& approaches, const ContactModel& model,
         const Array& directions) {
        const Values steps = view(approaches);
        const std::vector<Vector2> all = to_directions(directions);
        const CancellationCheck check_cancellation = keyboard_interrupt_check();
        const auto rows = [&] {
          const py::gil_scoped_release release;
          return press(candidates, steps, model.law, all, model.sliding, check_cancellation);
        }();
        return to_areal_table(rows);
      },
      py::arg("candidates"), py::kw_only(), py::arg("approaches").noconvert(), py::arg("model"),
      py::arg("directions").noconvert(),
      "Compute the contact sums of two maps, as a dict of columns with rows ordered by direction, then approach [µm].");
}

}  // namespace stiction::python
