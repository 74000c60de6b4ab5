// Argument checks shared by the contact calculations of profiles and of maps.
#pragma once

#include "stiction/array.hpp"

#include <string>

namespace stiction {

[[noreturn]] void fail(const std::string& message);

/// Check that there is at least one approach, and that all approaches are finite, >= 0 and strictly increasing.
/// Also check that no approach exceeds `deepest`, up to which candidates were found. Throws std::invalid_argument.
void check_approaches(Values approaches, double deepest);

/// Throw std::invalid_argument unless a direction is a horizontal unit vector.
void check_direction(const Vector2& direction);

}  // namespace stiction
