#include "stiction/law.hpp"

#include <doctest/doctest.h>

TEST_CASE("Hertz spheres carry what the contact radius says") {
  // With a = sqrt(R overlap): F = 4 E* a³ / (3 R) and A = π a². Numbers chosen to be exact: a = 2.
  const stiction::HertzSphere law{3.0};
  const auto [force, area] = law(0.5, 8.0);
  CHECK(force == doctest::Approx(4.0).epsilon(1e-15));
  CHECK(area == doctest::Approx(4.0 * std::numbers::pi).epsilon(1e-15));
}
