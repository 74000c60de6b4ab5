// Levels of profiles as rows (mean, lowest, highest) of an array.
#pragma once

#include "stiction/amplitude.hpp"

#include "arrays.hpp"

namespace stiction::python {

py::array_t<double> array_of(const std::vector<Level>& levels);
std::vector<Level> levels_of(const MatrixView& rows);

}  // namespace stiction::python
