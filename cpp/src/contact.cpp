#include "stiction/contact.hpp"

#include "multiversion.hpp"
#include "stiction/asperity.hpp"
#include "stiction/spline.hpp"
#include "text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
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

// Two spheres, at most one of them concave (Eq. 4). With p = δ - gap, by how much the points of the profiles have
// passed each other, X = (0, -p) + R_l n_l - R_u n_u. The overlap, R_u + R_l less the signed length of X, is written
// without the difference of two large numbers that it is where a body is nearly flat, as
// ((R_u + R_l)² - X²) / (|R_u + R_l| + |X|), and the centre is measured from the smaller sphere.
struct SpherePair {
  Vector2 apart;   // X at p = 0
  double gap;      // of the two points, at zero approach
  double reach;    // |R_u + R_l|
  double sign;     // of R_u R_l
  double lateral;  // R_u R_l |n_u + n_l|², which is zero where the slopes are equal
  double radius;   // effective, 1/R = 1/R_u + 1/R_l
  Vector2 pole;    // centre of the smaller sphere, relative to its own point
  double pole_radius;
  bool pole_below;  // the smaller sphere is the lower one

  Touch at(double approach) const {
    const double passed = approach - gap;
    const Vector2 x = apart - Vector2(0.0, passed);
    const double distance = x.norm();
    const Vector2 normal = sign / distance * x;
    const double overlap = sign * (lateral + passed * (2.0 * apart.y() - passed)) / (reach + distance);
    const double depth = pole_radius - 0.5 * overlap;
    const Vector2 centre =
        pole_below ? Vector2(pole + depth * normal) : Vector2(pole - depth * normal - Vector2(0.0, passed));
    return {normal, centre, overlap};
  }
};

// A sphere and a straight body: the limit of an infinite radius, in which the normal is the straight one's own.
struct SphereOnStraight {
  Vector2 normal;  // of the straight body, pointing upwards
  Vector2 centre;  // of the sphere, relative to its own point
  bool below;      // the sphere is below the straight body
  double gap;      // of the two points, at zero approach
  double radius;

  Touch at(double approach) const {
    const double passed = approach - gap;
    // How far the sphere's pole rises above its own point, and the points have passed each other, along the normal.
    const double overlap = radius + (below ? 1.0 : -1.0) * centre.dot(normal) + passed * normal.y();
    const double depth = radius - 0.5 * overlap;
    return {normal, below ? Vector2(centre + depth * normal) : Vector2(centre - depth * normal - Vector2(0.0, passed)),
            overlap};
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
  const bool lower_is_smaller = std::abs(lower.radius) <= std::abs(upper.radius);
  const Asperity& smaller = lower_is_smaller ? lower : upper;
  return SpherePair{upper.centre_offset() - lower.centre_offset(),
                    gap,
                    std::abs(upper.radius + lower.radius),
                    both_convex ? 1.0 : -1.0,
                    upper.radius * lower.radius * (upper.normal + lower.normal).squaredNorm(),
                    radius,
                    smaller.centre_offset(),
                    smaller.radius,
                    lower_is_smaller};
}

std::optional<SphereOnStraight> sphere_on_straight(const Asperity& sphere, Side side_of_sphere,
                                                   const Asperity& straight, double gap) {
  if (!(sphere.radius > 0.0) || !std::isfinite(sphere.radius)) {
    return std::nullopt;
  }
  const bool below = side_of_sphere == Side::lower;
  return SphereOnStraight{below ? Vector2(-straight.normal) : straight.normal, sphere.centre_offset(), below, gap,
                          sphere.radius};
}

// Rules 1, 2 and 4: the contact lies in its own cell, the bodies overlap, their centres have not crossed.
enum class Verdict { no_contact, crossed, contact };

Verdict judge(const Touch& touch, double half_cell) {
  if (!(touch.overlap > 0.0 && touch.centre.x() >= -half_cell && touch.centre.x() < half_cell)) {
    return Verdict::no_contact;
  }
  return touch.normal.y() > 0.0 ? Verdict::contact : Verdict::crossed;
}

// ---- Passes over the profiles -------------------------------------------------------------------------------------

// One pass over a pair: its first touch, and what shows which parts of it ever come near.
struct Screening {
  static constexpr std::size_t block = 64;

  double gap = std::numeric_limits<double>::infinity();  // the lowest on the grid
  std::vector<double> block_gap;                         // the lowest of each `block` points
  bool upper_finite = true;                              // no height is NaN or infinite
  bool lower_finite = true;
  double upper_largest = 0.0;  // of |height|
  double lower_largest = 0.0;
};

struct BlockScreening {
  double gap;
  double upper_zero;  // 0, or NaN where a height is not finite
  double lower_zero;
  double upper_largest;
  double lower_largest;
};

STICTION_MULTIVERSION
BlockScreening screen_block(const double* upper, const double* lower, std::size_t size) {
  constexpr std::size_t lanes = 16;
  double lowest[lanes];
  double upper_zero[lanes] = {};
  double lower_zero[lanes] = {};
  double upper_largest[lanes] = {};
  double lower_largest[lanes] = {};
  std::fill_n(lowest, lanes, std::numeric_limits<double>::infinity());
  const auto take = [&](std::size_t i, std::size_t lane) {
    const double gap = upper[i] - lower[i];
    lowest[lane] = gap < lowest[lane] ? gap : lowest[lane];
    upper_zero[lane] += upper[i] - upper[i];
    lower_zero[lane] += lower[i] - lower[i];
    upper_largest[lane] = std::max(upper_largest[lane], std::abs(upper[i]));
    lower_largest[lane] = std::max(lower_largest[lane], std::abs(lower[i]));
  };
  std::size_t i = 0;
  for (; i + lanes <= size; i += lanes) {
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      take(i + lane, lane);
    }
  }
  for (; i < size; ++i) {
    take(i, 0);
  }
  return {*std::min_element(lowest, lowest + lanes), std::accumulate(upper_zero, upper_zero + lanes, 0.0),
          std::accumulate(lower_zero, lower_zero + lanes, 0.0), *std::max_element(upper_largest, upper_largest + lanes),
          *std::max_element(lower_largest, lower_largest + lanes)};
}

Screening screen(Values upper, Values lower) {
  Screening result;
  result.block_gap.reserve(upper.size() / Screening::block + 1);
  for (std::size_t begin = 0; begin < upper.size(); begin += Screening::block) {
    const BlockScreening block =
        screen_block(upper.data() + begin, lower.data() + begin, std::min(Screening::block, upper.size() - begin));
    result.block_gap.push_back(block.gap);
    result.gap = std::min(result.gap, block.gap);
    result.upper_finite = result.upper_finite && block.upper_zero == 0.0;
    result.lower_finite = result.lower_finite && block.lower_zero == 0.0;
    result.upper_largest = std::max(result.upper_largest, block.upper_largest);
    result.lower_largest = std::max(result.lower_largest, block.lower_largest);
  }
  return result;
}

struct Stretch {
  std::size_t begin;
  std::size_t end;
};

// Stretches of the grid that hold all points whose gap above first touch is at most `largest`.
std::vector<Stretch> stretches_within(Values upper, Values lower, const Screening& screening, double largest) {
  constexpr std::size_t step = 8;      // points that are taken together
  constexpr std::size_t closest = 32;  // no stretches are nearer to each other
  std::vector<Stretch> stretches;
  for (std::size_t b = 0; b < screening.block_gap.size(); ++b) {
    if (!(screening.block_gap[b] - screening.gap <= largest)) {
      continue;
    }
    const std::size_t block_end = std::min((b + 1) * Screening::block, upper.size());
    for (std::size_t begin = b * Screening::block; begin < block_end; begin += step) {
      const std::size_t end = std::min(begin + step, block_end);
      bool within = false;
      for (std::size_t i = begin; i < end; ++i) {
        within = within || (upper[i] - lower[i]) - screening.gap <= largest;
      }
      if (!within) {
        continue;
      }
      if (!stretches.empty() && begin - stretches.back().end <= closest) {
        stretches.back().end = end;
      } else {
        stretches.push_back({begin, end});
      }
    }
  }
  return stretches;
}

// The largest second difference of the gap: what its spline can dip below the grid's own values is 3/8 of it, because
// |f''| of a natural spline is at most 3 of them per Δx², and a cubic dips below its ends by at most |f''| Δx² / 8.
STICTION_MULTIVERSION
double largest_second_difference(const double* upper, const double* lower, std::size_t size) {
  constexpr std::size_t lanes = 16;
  double largest[lanes] = {};
  const auto at = [&](std::size_t i) {
    return std::abs((upper[i - 1] - lower[i - 1]) - 2.0 * (upper[i] - lower[i]) + (upper[i + 1] - lower[i + 1]));
  };
  std::size_t i = 1;
  for (; i + lanes < size; i += lanes) {
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      largest[lane] = std::max(largest[lane], at(i + lane));
    }
  }
  for (; i + 1 < size; ++i) {
    largest[0] = std::max(largest[0], at(i));
  }
  return *std::max_element(largest, largest + lanes);
}

// Whether the points of a profile lie on a line, to the round-off of the largest height: such a body has no radius.
bool is_straight(Values heights, double largest) {
  const double round_off = 4.0 * std::numeric_limits<double>::epsilon() * largest;
  for (std::size_t i = 1; i + 1 < heights.size(); ++i) {
    if (std::abs((heights[i + 1] - heights[i]) - (heights[i] - heights[i - 1])) > round_off) {
      return false;
    }
  }
  return true;
}

// A profile and, of a stretch of it, the slopes and curvatures that the spline through the whole has.
class Body {
 public:
  Body(Values heights, double largest, double spacing, Side side)
      : heights_(heights), spacing_(spacing), side_(side), straight_(is_straight(heights, largest)) {}

  bool straight() const { return straight_; }

  void spline(std::size_t begin, std::size_t end) {
    begin_ = begin;
    const auto last = static_cast<double>(heights_.size() - 1);
    slope_.assign(end - begin, (heights_.back() - heights_.front()) / (last * spacing_));
    curvature_.assign(end - begin, 0.0);
    if (!straight_) {
      natural_spline_from(heights_, spacing_, static_cast<Index>(begin), slope_, curvature_);
    }
  }

  double height(std::size_t i) const { return heights_[i]; }
  const std::vector<double>& slopes() const { return slope_; }
  const std::vector<double>& curvatures() const { return curvature_; }
  double slope(std::size_t i) const { return slope_[i - begin_]; }
  double curvature(std::size_t i) const { return curvature_[i - begin_]; }

  // Between grid points i and i + 1, t [µm] from the first.
  double height(std::size_t i, double t) const {
    return height(i) + t * (slope(i) + 0.5 * t * (curvature(i) + t / (3.0 * spacing_) * bend(i)));
  }
  double slope(std::size_t i, double t) const { return slope(i) + t * (curvature(i) + 0.5 * t / spacing_ * bend(i)); }
  double curvature(std::size_t i, double t) const { return curvature(i) + t / spacing_ * bend(i); }

  Asperity asperity(std::size_t i, double t) const {
    return t == 0.0 ? stiction::asperity(slope(i), curvature(i), side_)
                    : stiction::asperity(slope(i, t), curvature(i, t), side_);
  }

 private:
  double bend(std::size_t i) const { return curvature(i + 1) - curvature(i); }

  Values heights_;
  double spacing_;
  Side side_;
  bool straight_;
  std::size_t begin_ = 0;
  std::vector<double> slope_;
  std::vector<double> curvature_;
};

struct Pair {
  Values upper;
  Values lower;
  double spacing;
};

// A place where two asperities face each other.
struct Site {
  std::size_t index;    // grid point
  double offset;        // from it [µm]
  double lower_height;  // [µm]
  double gap;           // above first touch [µm]
};

// ---- Which points or intervals may hold a contact: wide and cheap, so that few are left to look at one by one -------

// Slopes and curvatures of both bodies at consecutive points.
struct Derivatives {
  const double* upper_slope;
  const double* upper_curvature;
  const double* lower_slope;
  const double* lower_curvature;
};

// Points at which both bodies are convex and the contact centre passes through the cell between first touch and the
// largest approach. The centre moves one way as the distance of the sphere centres shrinks, so its two ends tell.
STICTION_MULTIVERSION
void mark_cells(Derivatives at, const double* upper, const double* lower, std::size_t size, double zero, double largest,
                double half_cell, unsigned char* marks) {
  constexpr double round_off = 1e-12;
  for (std::size_t i = 0; i < size; ++i) {
    const double upper_slope = at.upper_slope[i];
    const double lower_slope = at.lower_slope[i];
    const double gap = (upper[i] - lower[i]) - zero;
    // R = scale q and O = scale (slope, 1), with the sign of the side.
    const double upper_q2 = 1.0 + upper_slope * upper_slope;
    const double lower_q2 = 1.0 + lower_slope * lower_slope;
    const double upper_scale = upper_q2 / at.upper_curvature[i];
    const double lower_scale = -lower_q2 / at.lower_curvature[i];
    const double upper_radius = upper_scale * std::sqrt(upper_q2);
    const double lower_radius = lower_scale * std::sqrt(lower_q2);
    const double lower_x = lower_scale * lower_slope;
    const double apart_x = -upper_scale * upper_slope - lower_x;
    const double apart_y = gap + upper_scale + lower_scale - largest;
    const double least_y = apart_y > 0.0 ? apart_y : 0.0;
    const double farthest = upper_radius + lower_radius;
    const double nearest = std::sqrt(apart_x * apart_x + least_y * least_y);
    const double half_excess = 0.5 * (upper_radius - lower_radius);
    const double middle = lower_x + 0.5 * apart_x;
    const double first = middle - half_excess * apart_x / farthest;
    const double last = middle - half_excess * apart_x / nearest;
    const double limit = half_cell + round_off * (std::abs(lower_x) + std::abs(apart_x) + std::abs(half_excess));
    // What is not a number is left to the exact rules.
    const bool beside = ((first > limit) & (last > limit)) | ((first < -limit) & (last < -limit));
    const bool apart = nearest > farthest * (1.0 + round_off);
    const bool convex = (at.upper_curvature[i] > 0.0) & (at.lower_curvature[i] < 0.0);
    marks[i] = convex & (gap <= largest) & !beside & !apart;
  }
}

// Intervals [x_i, x_(i+1)) in which the gap may have a minimum, by the signs at their ends: its slope rises through
// zero between them, or comes down to zero and rises again, or rises through zero and comes down again.
STICTION_MULTIVERSION
void mark_minima(Derivatives at, std::size_t size, unsigned char* marks) {
  for (std::size_t i = 0; i < size; ++i) {
    const double slope = at.upper_slope[i] - at.lower_slope[i];
    const double curvature = at.upper_curvature[i] - at.lower_curvature[i];
    const double next_slope = at.upper_slope[i + 1] - at.lower_slope[i + 1];
    const double next_curvature = at.upper_curvature[i + 1] - at.lower_curvature[i + 1];
    const bool rises = (slope <= 0.0) & (next_slope > 0.0);
    const bool dips = (slope >= 0.0) & (curvature < 0.0) & (next_curvature > 0.0) & (next_slope > 0.0);
    const bool bulges = (slope <= 0.0) & (curvature > 0.0) & (next_curvature < 0.0) & (next_slope < 0.0);
    const bool starts = (slope == 0.0) & (curvature > 0.0);
    marks[i] = rises | dips | bulges | starts;
  }
}

// The local minimum of the splined gap in [x_i, x_(i+1)), if there is one: the root of the gap's slope, a quadratic
// there, at which the gap is convex.
std::optional<double> gap_minimum(const Body& upper, const Body& lower, std::size_t i, double spacing) {
  const double slope = upper.slope(i) - lower.slope(i);
  const double curvature = upper.curvature(i) - lower.curvature(i);
  if (slope == 0.0 && curvature > 0.0 && i > 0) {
    return 0.0;
  }
  // slope + curvature t + half_rate t²
  const double next_curvature = upper.curvature(i + 1) - lower.curvature(i + 1);
  const double half_rate = (next_curvature - curvature) / (2.0 * spacing);
  const double discriminant = curvature * curvature - 4.0 * half_rate * slope;
  if (!(discriminant > 0.0)) {
    return std::nullopt;
  }
  const double root = std::sqrt(discriminant);
  // The root at which the quadratic rises, in the form that does not cancel.
  const double t = curvature >= 0.0 ? -2.0 * slope / (curvature + root) : (root - curvature) / (2.0 * half_rate);
  if (slope < 0.0 && upper.slope(i + 1) - lower.slope(i + 1) > 0.0) {
    return std::clamp(t, 0.0, spacing);  // it is there, whatever round-off says
  }
  return t > 0.0 && t < spacing ? std::optional(t) : std::nullopt;
}

// ---- All contacts of a pair
// ------------------------------------------------------------------------------------------

// Calls visit(site, index of the approach, touch, effective radius, verdict) for every contact, and every would-be
// contact whose centres have crossed, from left to right.
template <class Visit>
void visit_contacts(const Pair& pair, const Screening& screening, Values approaches, const ContactModel& model,
                    const Visit& visit) {
  const std::size_t size = pair.upper.size();
  const double zero = screening.gap;
  const double largest = approaches.back();
  Body upper(pair.upper, screening.upper_largest, pair.spacing, Side::upper);
  Body lower(pair.lower, screening.lower_largest, pair.spacing, Side::lower);
  if (upper.straight() && lower.straight()) {
    return;  // no asperities: 1/R = 0 everywhere
  }
  const bool by_cell = model.detection == Detection::cell;
  const bool two_convex_spheres = model.curvature == Curvature::convex && !upper.straight() && !lower.straight();
  const double half_cell = by_cell ? 0.5 * pair.spacing : std::numeric_limits<double>::infinity();

  const auto site_at = [&](std::size_t i) -> std::optional<Site> {
    if (by_cell) {
      return Site{i, 0.0, pair.lower[i], (pair.upper[i] - pair.lower[i]) - zero};
    }
    const auto t = gap_minimum(upper, lower, i, pair.spacing);
    if (!t) {
      return std::nullopt;
    }
    const double lower_height = lower.height(i, *t);
    return Site{i, *t, lower_height, (upper.height(i, *t) - lower_height) - zero};
  };
  const auto visit_encounter = [&](const Site& site, const auto& encounter) {
    if (!encounter) {
      return;
    }
    const auto first = std::lower_bound(approaches.begin(), approaches.end(), site.gap);
    for (auto k = static_cast<std::size_t>(first - approaches.begin()); k < approaches.size(); ++k) {
      const Touch touch = encounter->at(approaches[k]);
      const Verdict verdict = judge(touch, half_cell);
      if (verdict != Verdict::no_contact) {
        visit(site, k, touch, encounter->radius, verdict);
      }
    }
  };
  const auto visit_site = [&](const Site& site) {
    const Asperity above = upper.asperity(site.index, site.offset);
    const Asperity below = lower.asperity(site.index, site.offset);
    if (upper.straight()) {
      visit_encounter(site, sphere_on_straight(below, Side::lower, above, site.gap));
    } else if (lower.straight()) {
      visit_encounter(site, sphere_on_straight(above, Side::upper, below, site.gap));
    } else {
      visit_encounter(site, sphere_pair(above, below, site.gap, model.curvature));
    }
  };

  // A cell belongs to a point; a minimum to the interval on the right of a point, and may dip below both its ends.
  const double dip = by_cell ? 0.0 : 0.375 * largest_second_difference(pair.upper.data(), pair.lower.data(), size);
  constexpr std::size_t longest = 254;  // points whose derivatives are at hand at a time
  std::array<unsigned char, longest> marks;
  for (const Stretch& stretch : stretches_within(pair.upper, pair.lower, screening, largest + dip)) {
    const std::size_t stretch_begin = by_cell || stretch.begin == 0 ? stretch.begin : stretch.begin - 1;
    const std::size_t stretch_end = by_cell ? stretch.end : std::min(stretch.end, size - 1);
    for (std::size_t begin = stretch_begin; begin < stretch_end; begin += longest) {
      const std::size_t end = std::min(begin + longest, stretch_end);
      const std::size_t count = end - begin;
      upper.spline(begin, by_cell ? end : end + 1);
      lower.spline(begin, by_cell ? end : end + 1);
      const Derivatives derivatives{upper.slopes().data(), upper.curvatures().data(), lower.slopes().data(),
                                    lower.curvatures().data()};
      if (!by_cell) {
        mark_minima(derivatives, count, marks.data());
      } else if (two_convex_spheres) {
        mark_cells(derivatives, pair.upper.data() + begin, pair.lower.data() + begin, count, zero, largest, half_cell,
                   marks.data());
      } else {
        marks.fill(1);
      }
      for (std::size_t i = begin; i < end; ++i) {
        if (marks[i - begin] != 0) {
          const std::optional<Site> site = site_at(i);
          if (site && site->gap <= largest) {
            visit_site(*site);
          }
        }
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

// Returns the screening, a pass which finds heights that are not finite as well.
Screening check(const Pair& pair, Values approaches, const ContactModel& model) {
  const auto fail = [](const std::string& what) { throw std::invalid_argument(what); };
  if (pair.upper.size() != pair.lower.size()) {
    fail("upper and lower must have equally many points, not " + std::to_string(pair.upper.size()) + " and " +
         std::to_string(pair.lower.size()));
  }
  if (pair.upper.size() < 4) {
    fail("upper and lower have " + std::to_string(pair.upper.size()) + " points, at least 4 are needed");
  }
  Screening screening = screen(pair.upper, pair.lower);
  if (!screening.upper_finite) {
    fail("upper has heights that are NaN or infinite");
  }
  if (!screening.lower_finite) {
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
  check(model.law);
  if (model.shear != 1 && model.shear != -1) {
    fail("shear is " + std::to_string(model.shear) + ", must be +1 or -1");
  }
  return screening;
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
      tangential_adhesive(approaches),
      overlap_load(approaches),
      load_beyond_hertz(approaches),
      load_below_grid(approaches),
      crossed_count(approaches) {}

std::vector<Contact> contacts(Values upper, Values lower, double spacing, double approach, const ContactModel& model) {
  const Pair pair{upper, lower, spacing};
  const Values approaches(&approach, 1);
  const Screening screening = check(pair, approaches, model);
  std::vector<Contact> result;
  const auto visit_with = [&](const auto& law) {
    visit_contacts(pair, screening, approaches, model,
                   [&](const Site& site, std::size_t, const Touch& touch, double radius, Verdict verdict) {
                     if (verdict == Verdict::crossed) {
                       return;
                     }
                     const auto [force, area] = law(touch.overlap, radius);
                     const Vector2 point(static_cast<double>(site.index) * spacing + site.offset, site.lower_height);
                     result.push_back({static_cast<Index>(site.index), point + touch.centre, touch.normal,
                                       tangent_of(touch.normal, model.shear), radius, touch.overlap, force, area,
                                       opposes(touch.normal, model.shear)});
                   });
  };
  std::visit(visit_with, model.law);
  return result;
}

LoadSums press(Values upper, Values lower, double spacing, Values approaches, const ContactModel& model) {
  constexpr double hertz_limit = 0.1;  // overlap / R
  const Pair pair{upper, lower, spacing};
  const Screening screening = check(pair, approaches, model);
  LoadSums sums(approaches.size());
  const double shear = model.shear;
  const auto visit_with = [&](const auto& law) {
    visit_contacts(pair, screening, approaches, model,
                   [&](const Site&, std::size_t k, const Touch& touch, double radius, Verdict verdict) {
                     if (verdict == Verdict::crossed) {
                       sums.crossed_count[k] += 1;
                       return;
                     }
                     const auto [force, area] = law(touch.overlap, radius);
                     const double load = force * touch.normal.y();
                     const double relative_overlap = touch.overlap / radius;
                     sums.contact_count[k] += 1;
                     sums.contact_area[k] += area;
                     sums.normal_elastic[k] += load;
                     sums.overlap_load[k] += load * relative_overlap;
                     sums.load_beyond_hertz[k] += relative_overlap > hertz_limit ? load : 0.0;
                     sums.load_below_grid[k] += radius < spacing ? load : 0.0;
                     if (opposes(touch.normal, model.shear)) {
                       const Vector2 tangent = tangent_of(touch.normal, model.shear);
                       sums.tangential_elastic[k] -= shear * force * touch.normal.x();
                       sums.normal_frictional[k] += force * tangent.y();
                       sums.tangential_frictional[k] -= shear * force * tangent.x();
                       sums.normal_adhesive[k] += area * tangent.y();
                       sums.tangential_adhesive[k] -= shear * area * tangent.x();
                     }
                   });
  };
  std::visit(visit_with, model.law);
  return sums;
}

}  // namespace stiction
