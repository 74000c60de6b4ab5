#include "sums.hpp"

namespace stiction::python {

Table to_table(const std::vector<Sums>& rows) {
  Table table;
  for (const Quantity& quantity : quantities) {
    const auto column_of = [&](auto member) -> py::array {
      using Value = std::conditional_t<std::is_same_v<decltype(member), Index Sums::*>, std::int64_t, double>;
      return column(rows, [&](const Sums& sums) { return static_cast<Value>(sums.*member); });
    };
    table[py::str(quantity.name.data(), quantity.name.size())] = std::visit(column_of, quantity.member);
  }
  return table;
}

void bind_sums(py::module_& module) {
  module.def(
      "quantities",
      [] {
        std::vector<std::tuple<std::string, std::string, std::string>> all;
        for (const Quantity& quantity : quantities) {
          all.emplace_back(quantity.name, quantity.unit, quantity.description);
        }
        return all;
      },
      "Return name, unit and description of the contact sums.");
}

}  // namespace stiction::python
