#include "checks.hpp"

#include "text.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

namespace stiction {

void fail(const std::string& what) { throw std::invalid_argument(what); }

void check_approaches(Values approaches, double deepest) {
  if (approaches.empty()) {
    fail("approaches is empty, at least one is needed");
  }
  for (std::size_t k = 0; k < approaches.size(); ++k) {
    if (!(approaches[k] >= 0.0) || !std::isfinite(approaches[k])) {
      fail("approach is " + text(approaches[k]) + " µm, must be 0 or above and finite");
    }
    if (k > 0 && !(approaches[k] > approaches[k - 1])) {
      fail("approaches must increase, but " + text(approaches[k - 1]) + " µm is followed by " + text(approaches[k]) +
           " µm");
    }
  }
  if (approaches.back() > deepest) {
    fail("approach is " + text(approaches.back()) + " µm, but candidates were looked for up to " + text(deepest) +
         " µm only");
  }
}

void check_direction(const Vector2& direction) {
  constexpr double round_off = 1e-12;
  if (!(std::abs(direction.squaredNorm() - 1.0) < round_off)) {
    fail("direction is (" + text(direction.x()) + ", " + text(direction.y()) + "), must be a unit vector");
  }
}

}  // namespace stiction
