// Argument checks shared by the contact calculations of profiles and of maps.
#pragma once

#include "stiction/array.hpp"

#include <string>

namespace stiction {

/// Throw std::invalid_argument with a message about the argument.
[[noreturn]] void fail(const std::string& message);

/// Check approaches: at least one, >= 0, finite, strictly increasing, and at most `deepest`.
/// `deepest` is the limit of the candidates. Throws std::invalid_argument.
void check_approaches(Values approaches, double deepest);

/// Check that a direction is a horizontal unit vector. Throws std::invalid_argument.
void check_direction(const Vector2& direction);

}  // namespace stiction
