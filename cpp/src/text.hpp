// Formatting of numbers in messages.
#pragma once

#include <cstdio>
#include <string>

namespace stiction {

inline std::string format_number(double value) {
  std::string digits(32, '\0');
  digits.resize(static_cast<std::size_t>(std::snprintf(digits.data(), digits.size(), "%g", value)));
  return digits;
}

}  // namespace stiction
