#include "stiction/law.hpp"

#include "text.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace stiction {

using std::numbers::pi;

ForceArea HertzSphere::operator()(double overlap, double radius) const {
  return {4.0 / 3.0 * effective_modulus * std::sqrt(radius * overlap) * overlap, pi * radius * overlap};
}

ForceArea HertzCylinder::operator()(double overlap, double radius) const {
  return {0.25 * pi * effective_modulus * overlap * width, 2.0 * width * std::sqrt(radius * overlap)};
}

ForceArea JacksonGreen::operator()(double overlap, double radius) const {
  constexpr double transition = 1.9;  // in critical interferences
  const double strain = yield_strength / effective_modulus;
  const double constraint = 1.295 * std::exp(0.736 * poisson_ratio);
  const double half_angle = 0.5 * pi * constraint * strain;
  const double ratio = overlap / (half_angle * half_angle * radius);
  const ForceArea elastic = HertzSphere{effective_modulus}(overlap, radius);
  if (ratio < transition) {
    return elastic;
  }
  const double spread = std::pow(ratio / transition, 0.14 * std::exp(23.0 * strain));
  const double contact_radius = half_angle * std::sqrt(ratio * spread);                     // in sphere radii
  const double hardness = 2.84 * (1.0 - std::exp(-0.82 * std::pow(contact_radius, -0.7)));  // in yield strengths
  const double critical_force = elastic.force / (ratio * std::sqrt(ratio));
  const double elastic_part = std::exp(-0.25 * std::pow(ratio, 5.0 / 12.0)) * ratio * std::sqrt(ratio);
  const double plastic_part = 4.0 * hardness / constraint * -std::expm1(-0.04 * std::pow(ratio, 5.0 / 9.0)) * ratio;
  return {critical_force * (elastic_part + plastic_part), elastic.area * spread};
}

namespace {

void require(bool condition, const char* name, double value, const char* allowed) {
  if (!condition) {
    throw std::invalid_argument(std::string(name) + " is " + text(value) + ", must be " + allowed);
  }
}

void require_positive(const char* name, double value, const char* unit) {
  require(value > 0.0 && std::isfinite(value), name, value, (std::string("above 0 and finite, in ") + unit).c_str());
}

void check_parameters(const HertzSphere&) {}
void check_parameters(const HertzCylinder& law) { require_positive("width", law.width, "µm"); }
void check_parameters(const JacksonGreen& law) {
  require_positive("yield_strength", law.yield_strength, "GPa");
  require(law.yield_strength < 0.1 * law.effective_modulus, "yield_strength", law.yield_strength,
          "below a tenth of the effective modulus, in GPa");
  require(law.poisson_ratio >= 0.0 && law.poisson_ratio <= 0.5, "poisson_ratio", law.poisson_ratio, "from 0 to 0.5");
}

}  // namespace

void check(const Law& law) {
  std::visit(
      [](const auto& one) {
        require_positive("effective_modulus", one.effective_modulus, "GPa");
        check_parameters(one);
      },
      law);
}

}  // namespace stiction
