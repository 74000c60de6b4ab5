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
  constexpr double transition = 1.9;  // in units of the critical interference
  const double strain = yield_strength / effective_modulus;
  const double constraint = 1.295 * std::exp(0.736 * poisson_ratio);
  const double half_angle = 0.5 * pi * constraint * strain;
  const double ratio = overlap / (half_angle * half_angle * radii.mean());
  const ForceArea elastic = HertzSphere{effective_modulus}(overlap, radii);
  if (ratio < transition) {
    return elastic;
  }
  const double spread = std::pow(ratio / transition, 0.14 * std::exp(23.0 * strain));
  const double contact_radius = half_angle * std::sqrt(ratio * spread);  // in units of the sphere radius
  const double hardness =
      2.84 * (1.0 - std::exp(-0.82 * std::pow(contact_radius, -0.7)));  // mean pressure in units of the yield strength
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
    throw std::invalid_argument("yield_strength must be below a tenth of effective_modulus, got " +
                                format_number(yield_strength) + " GPa");
  }
}

namespace {

template <class AnyLaw>
void check_parameter(const Parameter<AnyLaw>& parameter, double value) {
  const bool within = parameter.inclusive ? value >= parameter.low && value <= parameter.high
                                          : value > parameter.low && value < parameter.high;
  if (within) {
    return;
  }
  const std::string allowed = parameter.inclusive
                                  ? "from " + format_number(parameter.low) + " to " + format_number(parameter.high)
                                  : "above " + format_number(parameter.low) + " and finite";
  std::string got = format_number(value);
  if (!parameter.unit.empty()) {
    got += ' ';
    got += parameter.unit;
  }
  throw std::invalid_argument(std::string(parameter.name) + " must be " + allowed + ", got " + got);
}

template <class AnyLaw>
AnyLaw make_law(const std::map<std::string, double>& values) {
  AnyLaw law{};
  const auto parameters = AnyLaw::parameters();
  for (const auto& parameter : parameters) {
    const auto found = values.find(std::string(parameter.name));
    if (found == values.end()) {
      throw std::invalid_argument("law " + std::string(AnyLaw::name) + " requires the parameter " +
                                  std::string(parameter.name));
    }
    law.*(parameter.member) = found->second;
  }
  for (const auto& [name, value] : values) {
    if (std::none_of(parameters.begin(), parameters.end(),
                     [&](const auto& parameter) { return parameter.name == name; })) {
      throw std::invalid_argument("law " + std::string(AnyLaw::name) + " has no parameter " + name);
    }
  }
  check(law);
  return law;
}

template <class... Laws>
Law find_law(std::string_view name, const std::map<std::string, double>& parameters, std::variant<Laws...>*) {
  std::optional<Law> found;
  ((Laws::name == name ? void(found = make_law<Laws>(parameters)) : void()), ...);
  if (!found) {
    throw std::invalid_argument("unknown law " + std::string(name));
  }
  return *found;
}

}  // namespace

Law law(std::string_view name, const std::map<std::string, double>& parameters) {
  return find_law(name, parameters, static_cast<Law*>(nullptr));
}

void check(const Law& law) {
  std::visit(
      [](const auto& any_law) {
        for (const auto& parameter : std::decay_t<decltype(any_law)>::parameters()) {
          check_parameter(parameter, any_law.*(parameter.member));
        }
        if constexpr (requires { any_law.check(); }) {
          any_law.check();
        }
      },
      law);
}

}  // namespace stiction
