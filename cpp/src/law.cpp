#include "stiction/law.hpp"

#include "text.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace stiction {

using std::numbers::pi;

Vector2 HertzSphere::semi_axes(double overlap, const Radii& radii) const {
  return Vector2::Constant(std::sqrt(radii.mean() * overlap));
}

ForceArea HertzCylinder::operator()(double overlap, const Radii& radii) const {
  return {0.25 * pi * effective_modulus * overlap * width, 2.0 * width * std::sqrt(radii.mean() * overlap)};
}

Vector2 HertzCylinder::semi_axes(double overlap, const Radii& radii) const {
  const double along = 0.5 * width;
  const double across = std::sqrt(radii.mean() * overlap);
  return {std::max(along, across), std::min(along, across)};
}

ForceArea JacksonGreen::operator()(double overlap, const Radii& radii) const {
  constexpr double transition = 1.9;  // in critical interferences
  const double strain = yield_strength / effective_modulus;
  const double constraint = 1.295 * std::exp(0.736 * poisson_ratio);
  const double half_angle = 0.5 * pi * constraint * strain;
  const double ratio = overlap / (half_angle * half_angle * radii.mean());
  const ForceArea elastic = HertzSphere{effective_modulus}(overlap, radii);
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

Vector2 JacksonGreen::semi_axes(double overlap, const Radii& radii) const {
  return Vector2::Constant(std::sqrt((*this)(overlap, radii).area / pi));
}

void JacksonGreen::check() const {
  if (!(yield_strength < 0.1 * effective_modulus)) {
    throw std::invalid_argument("yield_strength is " + text(yield_strength) +
                                ", must be below a tenth of the effective modulus, in GPa");
  }
}

namespace {

template <class L>
void check_parameter(const Parameter<L>& parameter, double value) {
  const bool within = parameter.ends ? value >= parameter.low && value <= parameter.high
                                     : value > parameter.low && value < parameter.high;
  if (within) {
    return;
  }
  std::string allowed = parameter.ends ? "from " + text(parameter.low) + " to " + text(parameter.high)
                                       : "above " + text(parameter.low) + " and finite";
  if (!parameter.unit.empty()) {
    allowed += ", in " + std::string(parameter.unit);
  }
  throw std::invalid_argument(std::string(parameter.name) + " is " + text(value) + ", must be " + allowed);
}

template <class L>
L law_of(const std::map<std::string, double>& given) {
  L law{};
  const auto known = L::parameters();
  for (const auto& parameter : known) {
    const auto found = given.find(std::string(parameter.name));
    if (found == given.end()) {
      throw std::invalid_argument("law " + std::string(L::name) + " lacks its " + std::string(parameter.name));
    }
    law.*(parameter.member) = found->second;
  }
  for (const auto& each : given) {
    if (std::none_of(known.begin(), known.end(), [&](const auto& one) { return one.name == each.first; })) {
      throw std::invalid_argument("law " + std::string(L::name) + " has no parameter " + each.first);
    }
  }
  check(law);
  return law;
}

template <class... Laws>
Law law_among(std::string_view name, const std::map<std::string, double>& parameters, std::variant<Laws...>*) {
  std::optional<Law> found;
  ((Laws::name == name ? void(found = law_of<Laws>(parameters)) : void()), ...);
  if (!found) {
    throw std::invalid_argument("there is no law " + std::string(name));
  }
  return *found;
}

}  // namespace

Law law(std::string_view name, const std::map<std::string, double>& parameters) {
  return law_among(name, parameters, static_cast<Law*>(nullptr));
}

void check(const Law& law) {
  std::visit(
      [](const auto& one) {
        for (const auto& parameter : std::decay_t<decltype(one)>::parameters()) {
          check_parameter(parameter, one.*(parameter.member));
        }
        if constexpr (requires { one.check(); }) {
          one.check();
        }
      },
      law);
}

}  // namespace stiction
