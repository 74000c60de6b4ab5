#include "stiction/candidates.hpp"

#include "checks.hpp"
#include "stiction/detection.hpp"
#include "stiction/spline.hpp"
#include "text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>

namespace stiction {
namespace {

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

// A place that the detection has found.
struct Site {
  std::size_t index;    // grid point
  double offset;        // from it [µm]
  double lower_height;  // [µm]
  double gap;           // above first touch [µm]
};

std::optional<Site> site_at(const Body& upper, const Body& lower, std::size_t i, double spacing, double zero) {
  const auto t = gap_minimum(upper.slope(i) - lower.slope(i), upper.curvature(i) - lower.curvature(i),
                             upper.slope(i + 1) - lower.slope(i + 1), upper.curvature(i + 1) - lower.curvature(i + 1),
                             spacing, i == 0);
  if (!t) {
    return std::nullopt;
  }
  const double lower_height = lower.height(i, *t);
  return Site{i, *t, lower_height, (upper.height(i, *t) - lower_height) - zero};
}

// Whether asperities may touch there; if so, how they face each other.
bool encounters(const Body& upper, const Body& lower, const Site& site, Curvature curvature, Encounter& encounter) {
  const Asperity above = upper.asperity(site.index, site.offset);
  const Asperity below = lower.asperity(site.index, site.offset);
  const auto keep = [&](const auto& found) {
    if (found) {
      encounter = *found;
    }
    return found.has_value();
  };
  if (upper.straight()) {
    return keep(sphere_on_straight(below, Side::lower, above, site.gap));
  }
  if (lower.straight()) {
    return keep(sphere_on_straight(above, Side::upper, below, site.gap));
  }
  return keep(sphere_pair(above, below, site.gap, curvature));
}

void check(const ProfilePair& pair, const Screening& screening, double deepest) {
  if (pair.upper.size() < 4) {
    fail("upper and lower have " + std::to_string(pair.upper.size()) + " points, at least 4 are needed");
  }
  if (!screening.upper_finite) {
    fail("upper has heights that are NaN or infinite");
  }
  if (!screening.lower_finite) {
    fail("lower has heights that are NaN or infinite");
  }
  if (!(pair.spacing > 0.0) || !std::isfinite(pair.spacing)) {
    fail("spacing is " + text(pair.spacing) + " µm, must be above 0 and finite");
  }
  if (!(deepest >= 0.0) || !std::isfinite(deepest)) {
    fail("approach is " + text(deepest) + " µm, must be 0 or above and finite");
  }
}

}  // namespace

Detection detection(std::string_view word) {
  if (word == "cell") {
    return Detection::cell;
  }
  if (word == "gap-minimum") {
    return Detection::gap_minimum;
  }
  throw std::invalid_argument("detection is " + std::string(word) + ", must be cell or gap-minimum");
}

Curvature curvature(std::string_view word) {
  if (word == "convex") {
    return Curvature::convex;
  }
  if (word == "signed") {
    return Curvature::signed_;
  }
  throw std::invalid_argument("curvature is " + std::string(word) + ", must be convex or signed");
}

Screening screen(const ProfilePair& pair) {
  if (pair.upper.size() != pair.lower.size()) {
    fail("upper and lower must have equally many points, not " + std::to_string(pair.upper.size()) + " and " +
         std::to_string(pair.lower.size()));
  }
  return screen(pair.upper, pair.lower);
}

void for_each_candidate(const ProfilePair& pair, double deepest, Detection detection, Curvature curvature,
                        const std::function<void(const Candidate&)>& visit, const Checkpoint& checkpoint) {
  for_each_candidate(pair, screen(pair), deepest, detection, curvature, visit, checkpoint);
}

void for_each_candidate(const ProfilePair& pair, const Screening& screening, double deepest, Detection detection,
                        Curvature curvature, const std::function<void(const Candidate&)>& visit,
                        const Checkpoint& checkpoint) {
  check(pair, screening, deepest);
  const std::size_t size = pair.upper.size();
  const double zero = screening.gap;
  Body upper(pair.upper, screening.upper_largest, pair.spacing, Side::upper);
  Body lower(pair.lower, screening.lower_largest, pair.spacing, Side::lower);
  if (upper.straight() && lower.straight()) {
    return;  // no asperities: 1/R = 0 everywhere
  }
  const bool by_cell = detection == Detection::cell;
  const bool two_convex_spheres = curvature == Curvature::convex && !upper.straight() && !lower.straight();

  // A cell belongs to a point; a minimum to the interval on the right of a point, and may dip below both its ends.
  const double dip = by_cell ? 0.0 : largest_dip(pair.upper, pair.lower);
  constexpr std::size_t longest = 254;  // points whose derivatives are at hand at a time
  std::array<unsigned char, longest> marks;
  Candidate candidate{};
  for (const Stretch& stretch : stretches_within(pair.upper, pair.lower, screening, deepest + dip)) {
    const std::size_t stretch_begin = by_cell || stretch.begin == 0 ? stretch.begin : stretch.begin - 1;
    const std::size_t stretch_end = by_cell ? stretch.end : std::min(stretch.end, size - 1);
    for (std::size_t begin = stretch_begin; begin < stretch_end; begin += longest) {
      checkpoint();
      const std::size_t end = std::min(begin + longest, stretch_end);
      const std::size_t count = end - begin;
      upper.spline(begin, by_cell ? end : end + 1);
      lower.spline(begin, by_cell ? end : end + 1);
      const Derivatives derivatives{upper.slopes().data(), upper.curvatures().data(), lower.slopes().data(),
                                    lower.curvatures().data()};
      if (!by_cell) {
        mark_minima(derivatives, count, marks.data());
      } else if (two_convex_spheres) {
        mark_cells(derivatives, pair.upper.data() + begin, pair.lower.data() + begin, count, zero, deepest,
                   0.5 * pair.spacing, marks.data());
      } else {
        marks.fill(1);
      }
      for (std::size_t i = begin; i < end; ++i) {
        if (marks[i - begin] == 0) {
          continue;
        }
        const std::optional<Site> site = by_cell ? Site{i, 0.0, pair.lower[i], (pair.upper[i] - pair.lower[i]) - zero}
                                                 : site_at(upper, lower, i, pair.spacing, zero);
        if (!site || !(site->gap <= deepest)) {
          continue;
        }
        if (encounters(upper, lower, *site, curvature, candidate.encounter)) {
          const double x = static_cast<double>(i) * pair.spacing + site->offset;
          candidate.index = static_cast<Index>(i);
          candidate.position = Vector3(x, 0.0, site->lower_height);
          candidate.gap = site->gap;
          candidate.radii = radii(candidate.encounter);
          visit(candidate);
        }
      }
    }
  }
}

Candidates candidates(const ProfilePair& pair, double deepest, Curvature curvature, const Checkpoint& checkpoint) {
  Candidates found{{}, deepest, pair.spacing};
  for_each_candidate(
      pair, deepest, Detection::gap_minimum, curvature,
      [&](const Candidate& candidate) { found.all.push_back(candidate); }, checkpoint);
  return found;
}

}  // namespace stiction
