#include "stiction/areal.hpp"
#include "stiction/bicubic.hpp"

#include "arrays.hpp"
#include "checkpoint.hpp"
#include "contact.hpp"
#include "sums.hpp"

#include <array>

namespace stiction::python {
namespace {

// Eigen's view of a matrix would also take what is not contiguous, by a copy.
Eigen::Map<const Matrix> map_of(const Array& array) {
  if (array.ndim() != 2) {
    throw py::value_error("expected an array of 2 dimensions, got " + std::to_string(array.ndim()));
  }
  return {array.data(), array.shape(0), array.shape(1)};
}

std::vector<Vector2> directions_of(const Array& array) {
  const Eigen::Map<const Matrix> rows = map_of(array);
  if (rows.cols() != 2) {
    throw py::value_error("expected directions of 2 components, got " + std::to_string(rows.cols()));
  }
  std::vector<Vector2> directions;
  for (Index i = 0; i < rows.rows(); ++i) {
    directions.emplace_back(rows(i, 0), rows(i, 1));
  }
  return directions;
}

Table areal_table_of(const std::vector<ArealSums>& rows) {
  Table table = table_of(std::vector<Sums>(rows.begin(), rows.end()));
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
                              "Where two maps may touch, found once for any number of presses.")
      .def("__len__", [](const ArealCandidates& found) { return found.all.size(); })
      .def_readonly("deepest", &ArealCandidates::deepest, "Approach [µm] up to which they were looked for.")
      .def("columns", [](const ArealCandidates& found) {
        Table table;
        const auto cell = [&](const ArealCandidate& c) {
          return static_cast<std::int64_t>(c.row * found.columns + c.column);
        };
        table["index"] = column(found.all, cell);
        table["position"] = column(found.all, [](const ArealCandidate& c) { return c.position; });
        table["gap"] = column(found.all, [](const ArealCandidate& c) { return c.gap; });
        table["radii"] =
            column(found.all, [](const ArealCandidate& c) { return Vector2(c.radii.major, c.radii.minor); });
        return table;
      });

  module.def(
      "areal_quantities",
      [] {
        std::vector<std::tuple<std::string, std::string, std::string>> all;
        for (const ArealQuantity& quantity : areal_quantities) {
          all.emplace_back(quantity.name, quantity.unit, quantity.words);
        }
        return all;
      },
      "Name, unit and words of each of the sums that only areas have.");
  module.def(
      "candidates",
      [](const Array& upper, const Array& lower, const std::array<double, 2>& spacing, double deepest,
         const std::string& allowed) {
        const Eigen::Map<const Matrix> above = map_of(upper);
        const Eigen::Map<const Matrix> below = map_of(lower);
        const Checkpoint checkpoint = until_interrupted();
        const py::gil_scoped_release release;
        const SurfacePair pair{above, below, Vector2(spacing[1], spacing[0])};
        return candidates(pair, deepest, curvature(allowed), checkpoint);
      },
      py::arg("upper").noconvert(), py::arg("lower").noconvert(), py::kw_only(), py::arg("spacing"), py::arg("deepest"),
      py::arg("curvature"),
      "The gap minima of two maps up to a deepest approach [µm]; spacing of rows, then of columns.");
  module.def(
      "natural_slopes",
      [](const Array& heights, const std::array<double, 2>& spacing) {
        const Eigen::Map<const Matrix> map = map_of(heights);
        const std::array<py::ssize_t, 2> shape{map.rows(), map.cols()};
        std::array<py::array_t<double>, 2> along{py::array_t<double>(shape), py::array_t<double>(shape)};
        const auto filled = [&](std::size_t axis) {
          return Eigen::Map<Matrix>(along[axis].mutable_data(), map.rows(), map.cols());
        };
        auto by_y = filled(0);
        auto by_x = filled(1);
        {
          const py::gil_scoped_release release;
          natural_slopes(map, Vector2(spacing[1], spacing[0]), by_x, by_y);
        }
        return along;
      },
      py::arg("heights").noconvert(), py::kw_only(), py::arg("spacing"),
      "Slopes of a map along columns and along rows by natural cubic splines; spacing of rows, then of columns.");
  module.def(
      "contacts",
      [](const ArealCandidates& found, double approach, const ContactModel& model) {
        const auto rows = [&] {
          const py::gil_scoped_release release;
          return contacts(found, approach, model.law, model.direction);
        }();
        return table_of(rows);
      },
      py::arg("found"), py::kw_only(), py::arg("approach"), py::arg("model"),
      "Every contact of two maps at one approach [µm]: a dict of columns.");
  module.def(
      "press",
      [](const ArealCandidates& found, const Array& approaches, const ContactModel& model, const Array& directions) {
        const Values steps = view(approaches);
        const std::vector<Vector2> all = directions_of(directions);
        const Checkpoint checkpoint = until_interrupted();
        const auto rows = [&] {
          const py::gil_scoped_release release;
          return press(found, steps, model.law, all, model.sliding, checkpoint);
        }();
        return areal_table_of(rows);
      },
      py::arg("found"), py::kw_only(), py::arg("approaches").noconvert(), py::arg("model"),
      py::arg("directions").noconvert(),
      "Sums over the contacts of two maps: a dict of columns, direction by direction and in it by approach.");
}

}  // namespace stiction::python
