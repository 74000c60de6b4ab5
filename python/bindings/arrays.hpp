// Conversion between NumPy arrays and C++ data.
// Arguments must have the exact type and layout, and are not copied. Results take over the memory of C++ vectors.
#pragma once

#include "stiction/array.hpp"

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/typing.h>

#include <memory>
#include <vector>

namespace stiction::python {

namespace py = pybind11;

// Arguments are bound with .noconvert(), because the Python package converts arrays explicitly.
using Array = py::array_t<double, py::array::c_style>;

// Table with named columns of equal length.
using Table = py::typing::Dict<py::str, py::array>;

inline Values view(const Array& array) {
  if (array.ndim() != 1) {
    throw py::value_error("expected an array of 1 dimension, got " + std::to_string(array.ndim()));
  }
  return {array.data(), static_cast<std::size_t>(array.size())};
}

// Return a capsule that owns values for the lifetime of an array.
template <class T>
py::capsule make_owner(std::unique_ptr<std::vector<T>> values) {
  return {values.release(), [](void* pointer) { delete static_cast<std::vector<T>*>(pointer); }};
}

template <class T>
py::array_t<T> to_array(std::vector<T>&& values) {
  auto owner = std::make_unique<std::vector<T>>(std::move(values));
  T* data = owner->data();
  const auto size = static_cast<py::ssize_t>(owner->size());
  return py::array_t<T>(size, data, make_owner(std::move(owner)));
}

// Move n vectors into an array of shape (n, rows).
template <int rows>
py::array_t<double> to_array(std::vector<Eigen::Matrix<double, rows, 1>>&& values) {
  using Vector = Eigen::Matrix<double, rows, 1>;
  static_assert(sizeof(Vector) == rows * sizeof(double));
  auto owner = std::make_unique<std::vector<Vector>>(std::move(values));
  const double* data = owner->empty() ? nullptr : owner->front().data();
  const auto size = static_cast<py::ssize_t>(owner->size());
  return py::array_t<double>({size, py::ssize_t{rows}}, data, make_owner(std::move(owner)));
}

// Return an array that contains the value of `field` for each row.
template <class Row, class Field>
auto column(const std::vector<Row>& rows, Field field) {
  std::vector<std::decay_t<decltype(field(rows.front()))>> values;
  values.reserve(rows.size());
  for (const Row& row : rows) {
    values.push_back(field(row));
  }
  return to_array(std::move(values));
}

}  // namespace stiction::python
