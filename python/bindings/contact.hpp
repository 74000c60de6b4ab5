// Conversion of contacts to a table of columns.
#pragma once

#include "stiction/contact.hpp"

#include "arrays.hpp"

namespace stiction::python {

Table to_table(const std::vector<Contact>& rows);

}  // namespace stiction::python
