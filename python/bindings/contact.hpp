// Contacts at an approach as columns.
#pragma once

#include "stiction/contact.hpp"

#include "arrays.hpp"

namespace stiction::python {

Table table_of(const std::vector<Contact>& rows);

}  // namespace stiction::python
