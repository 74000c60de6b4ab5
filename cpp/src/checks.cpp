#include "checks.hpp"

#include "text.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

namespace stiction {

void fail(const std::string& message) { throw std::invalid_argument(message); }

void check_approaches(Values approaches, double deepest) {
  if (approaches.empty()) {
    fail("approaches must not be empty");
  }
  for (std::size_t k = 0; k < approaches.size(); ++k) {
    if (!(approaches[k] >= 0.0) || !std::isfinite(approaches[k])) {
      fail("approach must be at least 0 and finite, got " + format_number(approaches[k]) + " µm");
    }
    if (k > 0 && !(approaches[k] > approaches[k - 1])) {
      fail("approaches must increase, got " + format_number(approaches[k - 1]) + " µm followed by " +
           format_number(approaches[k]) + " µm");
    }
  }
  if (approaches.back() > deepest) {
    fail("approach must be at most " + format_number(deepest) + " µm, the limit of the candidates, got " +
         format_number(approaches.back()) + " µm");
  }
}

void check_direction(const Vector2& direction) {
  constexpr double round_off = 1e-12;
  if (!(std::abs(direction.squaredNorm() - 1.0) < round_off)) {
    fail("direction must be a unit vector, got (" + format_number(direction.x()) + ", " + format_number(direction.y()) +
         ")");
  }
}

}  // namespace stiction
