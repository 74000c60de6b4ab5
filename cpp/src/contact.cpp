#include "stiction/contact.hpp"

#include "multiversion.hpp"
#include "stiction/asperity.hpp"
#include "stiction/spline.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>

namespace stiction {
namespace {

// ---- Geometry of two asperities that face each other at one grid point --------------------------------------------

// Positions are relative to the point of the lower profile.
struct Touch {
  Vector2 normal;  // from the lower to the upper body
  Vector2 centre;  // [µm]
  double overlap;  // [µm]
};

// Two spheres, at most one of them concave (Eq. 4).
struct SpherePair {
  Vector2 lower_centre;  // O_l
  Vector2 apart;         // X = O_u - O_l at zero approach
  double reach;          // |R_u + R_l|
  double half_excess;    // (R_u - R_l) / 2
  double sign;           // of R_u R_l
  double radius;         // effective, 1/R = 1/R_u + 1/R_l

  Touch at(double approach) const {
    const Vector2 x = apart - Vector2(0.0, approach);
    const double distance = x.norm();
    const Vector2 normal = sign / distance * x;
    return {normal, lower_centre + 0.5 * x - half_excess * normal, sign * (reach - distance)};
  }
};

// A sphere and a flat: the limit of an infinite radius, in which the normal is the flat's own.
struct SphereOnFlat {
  Vector2 centre;        // contact centre at zero overlap: the pole of the sphere
  double side;           // +1 the sphere is below the flat, -1 above
  double first_overlap;  // at zero approach
  double radius;

  Touch at(double approach) const {
    const double overlap = first_overlap + approach;
    // An upper sphere comes down with the approach; a lower one stays where it is.
    const double shift = side > 0.0 ? 0.0 : approach;
    return {Vector2(0.0, 1.0), centre - Vector2(0.0, shift + side * 0.5 * overlap), overlap};
  }
};

std::optional<SpherePair> sphere_pair(const Asperity& upper, const Asperity& lower, double gap, Curvature allowed) {
  const bool both_convex = upper.radius > 0.0 && lower.radius > 0.0;
  if (!both_convex &&
      (allowed == Curvature::convex || !(upper.radius + lower.radius < 0.0) || upper.radius * lower.radius >= 0.0)) {
    return std::nullopt;
  }
  const double radius = upper.radius * lower.radius / (upper.radius + lower.radius);
  if (!std::isfinite(radius)) {
    return std::nullopt;
  }
  return SpherePair{lower.centre_offset(),
                    Vector2(0.0, gap) + upper.centre_offset() - lower.centre_offset(),
                    std::abs(upper.radius + lower.radius),
                    0.5 * (upper.radius - lower.radius),
                    both_convex ? 1.0 : -1.0,
                    radius};
}

std::optional<SphereOnFlat> sphere_on_flat(const Asperity& sphere, Side side_of_sphere, double gap) {
  if (!(sphere.radius > 0.0) || !std::isfinite(sphere.radius)) {
    return std::nullopt;
  }
  const bool below = side_of_sphere == Side::lower;
  const double side = below ? 1.0 : -1.0;
  const Vector2 point(0.0, below ? 0.0 : gap);
  const Vector2 pole = point + sphere.centre_offset() + Vector2(0.0, side * sphere.radius);
  // What the pole rises above the profile point, less the gap at that point.
  return SphereOnFlat{pole, side, sphere.radius * (1.0 - side * sphere.normal.y()) - gap, sphere.radius};
}

// Rules 1, 2 and 4: the contact lies in its own cell, the bodies overlap, their centres have not crossed.
bool is_contact(const Touch& touch, double half_cell) {
  return touch.centre.x() >= -half_cell && touch.centre.x() < half_cell && touch.overlap > 0.0 &&
         touch.normal.y() > 0.0;
}

// ---- Passes over the profiles -------------------------------------------------------------------------------------

STICTION_MULTIVERSION
double lowest_gap(const double* upper, const double* lower, std::size_t size) {
  constexpr std::size_t lanes = 16;
  double lowest[lanes];
  std::fill_n(lowest, lanes, std::numeric_limits<double>::infinity());
  std::size_t i = 0;
  for (; i + lanes <= size; i += lanes) {
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      const double gap = upper[i + lane] - lower[i + lane];
      lowest[lane] = gap < lowest[lane] ? gap : lowest[lane];
    }
  }
  for (; i < size; ++i) {
    lowest[0] = std::min(lowest[0], upper[i] - lower[i]);
  }
  return *std::min_element(lowest, lowest + lanes);
}

STICTION_MULTIVERSION
bool all_finite(const double* values, std::size_t size) {
  constexpr std::size_t lanes = 16;
  double zero[lanes] = {};  // stays zero, or turns into NaN
  std::size_t i = 0;
  for (; i + lanes <= size; i += lanes) {
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      zero[lane] += values[i + lane] * 0.0;
    }
  }
  for (; i < size; ++i) {
    zero[0] += values[i] * 0.0;
  }
  return std::all_of(zero, zero + lanes, [](double lane) { return lane == 0.0; });
}

bool is_flat(Values heights) {
  return std::all_of(heights.begin(), heights.end(), [&](double height) { return height == heights.front(); });
}

// Slopes and curvatures of a stretch of a profile, as the spline through the whole profile has them.
class SplineWindow {
 public:
  explicit SplineWindow(Values heights, double spacing)
      : heights_(heights), spacing_(spacing), flat_(is_flat(heights)) {}

  bool flat() const { return flat_; }

  void move(std::size_t first, std::size_t last) {
    if (flat_) {
      return;
    }
    constexpr auto reach = static_cast<std::size_t>(spline_reach);
    begin_ = first > reach ? first - reach : 0;
    const std::size_t end = std::min(last + 1 + reach, heights_.size());
    slope_.resize(end - begin_);
    curvature_.resize(end - begin_);
    natural_spline(heights_.subspan(begin_, end - begin_), spacing_, slope_, curvature_);
  }

  Asperity asperity_at(std::size_t i, Side side) const {
    return asperity(slope_[i - begin_], curvature_[i - begin_], side);
  }

 private:
  Values heights_;
  double spacing_;
  bool flat_;
  std::size_t begin_ = 0;
  std::vector<double> slope_;
  std::vector<double> curvature_;
};

struct Pair {
  Values upper;
  Values lower;
  double spacing;
};

// Calls visit(grid point, index of the approach, touch, effective radius) for every contact, grid point by grid point.
template <class Visit>
void visit_contacts(const Pair& pair, Values approaches, Curvature curvature, const Visit& visit) {
  const double touch_gap = lowest_gap(pair.upper.data(), pair.lower.data(), pair.upper.size());
  const auto gap_at = [&](std::size_t i) { return (pair.upper[i] - pair.lower[i]) - touch_gap; };
  const double half_cell = 0.5 * pair.spacing;

  std::vector<std::size_t> candidates;
  for (std::size_t i = 0; i < pair.upper.size(); ++i) {
    if (gap_at(i) <= approaches.back()) {
      candidates.push_back(i);
    }
  }

  SplineWindow upper(pair.upper, pair.spacing);
  SplineWindow lower(pair.lower, pair.spacing);
  if (upper.flat() && lower.flat()) {
    return;  // no asperities: 1/R = 0 everywhere
  }

  const auto visit_approaches = [&](std::size_t i, double gap, const auto& encounter) {
    const auto first = std::lower_bound(approaches.begin(), approaches.end(), gap);
    for (auto k = static_cast<std::size_t>(first - approaches.begin()); k < approaches.size(); ++k) {
      const Touch touch = encounter->at(approaches[k]);
      if (is_contact(touch, half_cell)) {
        visit(i, k, touch, encounter->radius);
      }
    }
  };

  // Windows of neighbouring candidates; no longer than stays in cache, no closer than their splines overlap.
  constexpr std::size_t longest = 4096;
  constexpr auto closest = static_cast<std::size_t>(2 * spline_reach);
  for (std::size_t begin = 0; begin < candidates.size();) {
    std::size_t end = begin + 1;
    while (end < candidates.size() && candidates[end] - candidates[end - 1] <= closest &&
           candidates[end] - candidates[begin] < longest) {
      ++end;
    }
    upper.move(candidates[begin], candidates[end - 1]);
    lower.move(candidates[begin], candidates[end - 1]);
    for (; begin < end; ++begin) {
      const std::size_t i = candidates[begin];
      const double gap = gap_at(i);
      if (upper.flat()) {
        if (const auto encounter = sphere_on_flat(lower.asperity_at(i, Side::lower), Side::lower, gap)) {
          visit_approaches(i, gap, encounter);
        }
      } else if (lower.flat()) {
        if (const auto encounter = sphere_on_flat(upper.asperity_at(i, Side::upper), Side::upper, gap)) {
          visit_approaches(i, gap, encounter);
        }
      } else if (const auto encounter = sphere_pair(upper.asperity_at(i, Side::upper),
                                                    lower.asperity_at(i, Side::lower), gap, curvature)) {
        visit_approaches(i, gap, encounter);
      }
    }
  }
}

// ---- Friction -----------------------------------------------------------------------------------------------------

// A contact opposes the motion where the normal force on the upper body points against it; σ = shear.
bool opposes(const Vector2& normal, int shear) { return shear * normal.x() < 0.0; }

// The direction of the friction that an opposing contact puts on the upper body, σ (-n_z, n_x).
Vector2 tangent_of(const Vector2& normal, int shear) { return shear * Vector2(-normal.y(), normal.x()); }

// ---- Checks -------------------------------------------------------------------------------------------------------

std::string text(double value) {
  std::string digits(32, '\0');
  digits.resize(static_cast<std::size_t>(std::snprintf(digits.data(), digits.size(), "%g", value)));
  return digits;
}

void check(const Pair& pair, Values approaches, const ContactModel& model) {
  const auto fail = [](const std::string& what) { throw std::invalid_argument(what); };
  if (pair.upper.size() != pair.lower.size()) {
    fail("upper and lower must have equally many points, not " + std::to_string(pair.upper.size()) + " and " +
         std::to_string(pair.lower.size()));
  }
  if (pair.upper.size() < 4) {
    fail("upper and lower have " + std::to_string(pair.upper.size()) + " points, at least 4 are needed");
  }
  if (!all_finite(pair.upper.data(), pair.upper.size())) {
    fail("upper has heights that are NaN or infinite");
  }
  if (!all_finite(pair.lower.data(), pair.lower.size())) {
    fail("lower has heights that are NaN or infinite");
  }
  if (!(pair.spacing > 0.0) || !std::isfinite(pair.spacing)) {
    fail("spacing is " + text(pair.spacing) + " µm, must be above 0 and finite");
  }
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
  const double modulus = std::visit([](const auto& law) { return law.effective_modulus; }, model.law);
  if (!(modulus > 0.0) || !std::isfinite(modulus)) {
    fail("effective_modulus is " + text(modulus) + " GPa, must be above 0 and finite");
  }
  if (model.shear != 1 && model.shear != -1) {
    fail("shear is " + std::to_string(model.shear) + ", must be +1 or -1");
  }
}

}  // namespace

LoadSums::LoadSums(std::size_t approaches)
    : contact_count(approaches),
      contact_area(approaches),
      normal_elastic(approaches),
      tangential_elastic(approaches),
      normal_frictional(approaches),
      tangential_frictional(approaches),
      normal_adhesive(approaches),
      tangential_adhesive(approaches) {}

std::vector<Contact> contacts(Values upper, Values lower, double spacing, double approach, const ContactModel& model) {
  const Pair pair{upper, lower, spacing};
  const Values approaches(&approach, 1);
  check(pair, approaches, model);
  std::vector<Contact> result;
  std::visit(
      [&](const auto& law) {
        visit_contacts(pair, approaches, model.curvature,
                       [&](std::size_t i, std::size_t, const Touch& touch, double radius) {
                         const ForceArea carried = law(touch.overlap, radius);
                         const Vector2 point(static_cast<double>(i) * spacing, lower[i]);
                         result.push_back({static_cast<Index>(i), point + touch.centre, touch.normal,
                                           tangent_of(touch.normal, model.shear), radius, touch.overlap, carried.force,
                                           carried.area, opposes(touch.normal, model.shear)});
                       });
      },
      model.law);
  return result;
}

LoadSums press(Values upper, Values lower, double spacing, Values approaches, const ContactModel& model) {
  const Pair pair{upper, lower, spacing};
  check(pair, approaches, model);
  LoadSums sums(approaches.size());
  const double shear = model.shear;
  std::visit(
      [&](const auto& law) {
        visit_contacts(pair, approaches, model.curvature,
                       [&](std::size_t, std::size_t k, const Touch& touch, double radius) {
                         const auto [force, area] = law(touch.overlap, radius);
                         sums.contact_count[k] += 1;
                         sums.contact_area[k] += area;
                         sums.normal_elastic[k] += force * touch.normal.y();
                         if (opposes(touch.normal, model.shear)) {
                           const Vector2 tangent = tangent_of(touch.normal, model.shear);
                           sums.tangential_elastic[k] -= shear * force * touch.normal.x();
                           sums.normal_frictional[k] += force * tangent.y();
                           sums.tangential_frictional[k] -= shear * force * tangent.x();
                           sums.normal_adhesive[k] += area * tangent.y();
                           sums.tangential_adhesive[k] -= shear * area * tangent.x();
                         }
                       });
      },
      model.law);
  return sums;
}

}  // namespace stiction
