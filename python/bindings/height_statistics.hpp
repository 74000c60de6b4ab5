// Conversion between the height statistics of profiles and an array with the columns (mean, min, max).
#pragma once

#include "stiction/amplitude.hpp"

#include "arrays.hpp"

namespace stiction::python {

py::array_t<double> to_array(const std::vector<HeightStatistics>& statistics);
std::vector<HeightStatistics> to_height_statistics(const MatrixView& rows);

}  // namespace stiction::python
