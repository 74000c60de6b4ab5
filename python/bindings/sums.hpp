// The sums at each approach as columns.
#pragma once

#include "stiction/sums.hpp"

#include "arrays.hpp"

namespace stiction::python {

Table table_of(const std::vector<Sums>& rows);

}  // namespace stiction::python
