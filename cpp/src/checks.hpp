// What presses of profiles and of surfaces ask of their arguments.
#pragma once

#include "stiction/array.hpp"

#include <string>

namespace stiction {

/// Throws std::invalid_argument.
[[noreturn]] void fail(const std::string& what);

/// At least one, >= 0, finite, strictly increasing and none beyond `deepest`, up to which candidates were looked for.
/// Throws std::invalid_argument.
void check_approaches(Values approaches, double deepest);

/// A unit vector. Throws std::invalid_argument.
void check_direction(const Vector2& direction);

}  // namespace stiction
