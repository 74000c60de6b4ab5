// Checks of arguments, shared by the contact calculations for profiles and for maps.
#pragma once

#include "stiction/array.hpp"

#include <string>

namespace stiction {

[[noreturn]] void fail(const std::string& message);

/// Throw std::invalid_argument unless approaches are finite, >= 0, strictly increasing and at most `deepest`.
void check_approaches(Values approaches, double deepest);

void check_direction(const Vector2& direction);

}  // namespace stiction
