#include "stiction/jackknife.hpp"

#include "arrays.hpp"

#include <algorithm>

namespace stiction::python {
namespace {

// Array in which several curves or several steps may share memory.
using StridedArray = py::array_t<double, 0>;
using IndexArray = py::array_t<Index, py::array::c_style>;

constexpr auto double_size = static_cast<py::ssize_t>(sizeof(double));

// Return the array, or a copy if the repetitions of a curve are not contiguous.
StridedArray make_repetitions_contiguous(const StridedArray& curves) {
  if (curves.strides(2) == double_size) {
    return curves;
  }
  return Array::ensure(curves);
}

CurveView view_curves(const StridedArray& curves) {
  return {curves.data(), curves.strides(0) / double_size, curves.strides(1) / double_size};
}

std::span<const Index> view_indices(const IndexArray& indices, Index end) {
  const std::span<const Index> view(indices.data(), static_cast<std::size_t>(indices.size()));
  if (std::any_of(view.begin(), view.end(), [end](Index index) { return index < 0 || index >= end; })) {
    throw py::value_error("indices must be below " + std::to_string(end));
  }
  return view;
}

}  // namespace

void bind_jackknife(py::module_& module) {
  module.def(
      "jackknife_sums",
      [](const StridedArray& loads, const StridedArray& values, const IndexArray& curve, const IndexArray& step,
         const Array& fraction, const Array& load, const Array& mean, const Array& slope, Index total_repetitions) {
        if (loads.ndim() != 3 || values.ndim() != 3 || !std::equal(loads.shape(), loads.shape() + 3, values.shape())) {
          throw py::value_error("loads and values must have the same shape (curves, steps, repetitions)");
        }
        const CurvePoints points{view_indices(curve, loads.shape(0)),
                                 view_indices(step, loads.shape(1)),
                                 view(fraction),
                                 view(load),
                                 view(mean),
                                 view(slope)};
        const std::size_t count = points.curve.size();
        for (const std::size_t size : {points.step.size(), points.fraction.size(), points.load.size(),
                                       points.mean.size(), points.slope.size()}) {
          if (size != count) {
            throw py::value_error("all arrays of points must have the same length");
          }
        }
        const StridedArray load_rows = make_repetitions_contiguous(loads);
        const StridedArray value_rows = make_repetitions_contiguous(values);
        const CurveView load_curves = view_curves(load_rows);
        const CurveView value_curves = view_curves(value_rows);
        const Index repetitions = loads.shape(2);
        py::array_t<double> sums({jackknife_sum_rows, static_cast<Index>(count)});
        Eigen::Map<Matrix> table(sums.mutable_data(), jackknife_sum_rows, static_cast<Index>(count));
        {
          const py::gil_scoped_release release;
          jackknife_sums(points, load_curves, value_curves, repetitions, total_repetitions, table);
        }
        return sums;
      },
      py::arg("loads").noconvert(), py::arg("values").noconvert(), py::kw_only(), py::arg("curve").noconvert(),
      py::arg("step").noconvert(), py::arg("fraction").noconvert(), py::arg("load").noconvert(),
      py::arg("mean").noconvert(), py::arg("slope").noconvert(), py::arg("total_repetitions"),
      "Compute power sums of jackknife values (10, points) from curves of loads and values (curves, steps, "
      "repetitions).");
}

}  // namespace stiction::python
