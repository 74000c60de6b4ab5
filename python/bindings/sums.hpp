// Conversion of contact sums to a table of columns.
#pragma once

#include "stiction/sums.hpp"

#include "arrays.hpp"

namespace stiction::python {

Table to_table(const std::vector<Sums>& rows);

}  // namespace stiction::python
