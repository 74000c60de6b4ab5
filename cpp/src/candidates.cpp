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

// Spline through a whole profile. Its derivatives are stored only at a range of grid points.
class SplinedProfile {
 public:
  SplinedProfile(Values heights, double max_abs, double spacing, Side side)
      : heights_(heights), spacing_(spacing), side_(side), is_flat_(is_straight(heights, max_abs)) {}

  bool is_flat() const { return is_flat_; }

  void compute_derivatives(std::size_t begin, std::size_t end) {
    begin_ = begin;
    const auto last = static_cast<double>(heights_.size() - 1);
    slope_.assign(end - begin, (heights_.back() - heights_.front()) / (last * spacing_));
    curvature_.assign(end - begin, 0.0);
    if (!is_flat_) {
      natural_spline_from(heights_, spacing_, static_cast<Index>(begin), slope_, curvature_);
    }
  }

  double height(std::size_t i) const { return heights_[i]; }
  const std::vector<double>& slopes() const { return slope_; }
  const std::vector<double>& curvatures() const { return curvature_; }
  double slope(std::size_t i) const { return slope_[i - begin_]; }
  double curvature(std::size_t i) const { return curvature_[i - begin_]; }

  // `t` is the distance [µm] from point i towards point i + 1, and at most the grid spacing.
  double height(std::size_t i, double t) const {
    return height(i) + t * (slope(i) + 0.5 * t * (curvature(i) + t / (3.0 * spacing_) * curvature_change(i)));
  }
  double slope(std::size_t i, double t) const {
    return slope(i) + t * (curvature(i) + 0.5 * t / spacing_ * curvature_change(i));
  }
  double curvature(std::size_t i, double t) const { return curvature(i) + t / spacing_ * curvature_change(i); }

  Asperity asperity(std::size_t i, double t) const {
    return t == 0.0 ? stiction::asperity(slope(i), curvature(i), side_)
                    : stiction::asperity(slope(i, t), curvature(i, t), side_);
  }

 private:
  double curvature_change(std::size_t i) const { return curvature(i + 1) - curvature(i); }

  Values heights_;
  double spacing_;
  Side side_;
  bool is_flat_;
  std::size_t begin_ = 0;
  std::vector<double> slope_;
  std::vector<double> curvature_;
};

struct Site {
  std::size_t index;
  double offset;  // distance from the grid point `index` [µm]
  double lower_height;
  double gap;
};

std::optional<Site> find_site(const SplinedProfile& upper, const SplinedProfile& lower, std::size_t i, double spacing,
                              double zero) {
  const auto t = gap_minimum(upper.slope(i) - lower.slope(i), upper.curvature(i) - lower.curvature(i),
                             upper.slope(i + 1) - lower.slope(i + 1), upper.curvature(i + 1) - lower.curvature(i + 1),
                             spacing, i == 0);
  if (!t) {
    return std::nullopt;
  }
  const double lower_height = lower.height(i, *t);
  return Site{i, *t, lower_height, (upper.height(i, *t) - lower_height) - zero};
}

// Returns whether the two asperities at the site can touch.
bool set_asperity_pair(const SplinedProfile& upper, const SplinedProfile& lower, const Site& site, Curvature curvature,
                       AsperityPair& asperity_pair) {
  const Asperity upper_asperity = upper.asperity(site.index, site.offset);
  const Asperity lower_asperity = lower.asperity(site.index, site.offset);
  const auto store = [&](const auto& pair) {
    if (pair) {
      asperity_pair = *pair;
    }
    return pair.has_value();
  };
  if (upper.is_flat()) {
    return store(sphere_on_flat(lower_asperity, Side::lower, upper_asperity, site.gap));
  }
  if (lower.is_flat()) {
    return store(sphere_on_flat(upper_asperity, Side::upper, lower_asperity, site.gap));
  }
  return store(sphere_pair(upper_asperity, lower_asperity, site.gap, curvature));
}

void check(const ProfilePair& pair, const Prefilter& prefilter, double deepest) {
  if (pair.upper.size() < 4) {
    fail("upper and lower must have at least 4 points, got " + std::to_string(pair.upper.size()));
  }
  if (!prefilter.upper_finite) {
    fail("upper must be finite, got NaN or infinite heights");
  }
  if (!prefilter.lower_finite) {
    fail("lower must be finite, got NaN or infinite heights");
  }
  if (!(pair.spacing > 0.0) || !std::isfinite(pair.spacing)) {
    fail("spacing must be above 0 and finite, got " + format_number(pair.spacing) + " µm");
  }
  if (!(deepest >= 0.0) || !std::isfinite(deepest)) {
    fail("approach must be at least 0 and finite, got " + format_number(deepest) + " µm");
  }
}

}  // namespace

Detection detection(std::string_view name) {
  if (name == "cell") {
    return Detection::cell;
  }
  if (name == "gap-minimum") {
    return Detection::gap_minimum;
  }
  throw std::invalid_argument("detection must be cell or gap-minimum, got " + std::string(name));
}

Curvature curvature(std::string_view name) {
  if (name == "convex") {
    return Curvature::convex;
  }
  if (name == "signed") {
    return Curvature::signed_;
  }
  throw std::invalid_argument("curvature must be convex or signed, got " + std::string(name));
}

Prefilter run_prefilter(const ProfilePair& pair) {
  if (pair.upper.size() != pair.lower.size()) {
    fail("upper and lower must have equal numbers of points, got " + std::to_string(pair.upper.size()) + " and " +
         std::to_string(pair.lower.size()));
  }
  return run_prefilter(pair.upper, pair.lower);
}

void for_each_candidate(const ProfilePair& pair, double deepest, Detection detection, Curvature curvature,
                        const std::function<void(const Candidate&)>& visit,
                        const CancellationCheck& check_cancellation) {
  for_each_candidate(pair, run_prefilter(pair), deepest, detection, curvature, visit, check_cancellation);
}

void for_each_candidate(const ProfilePair& pair, const Prefilter& prefilter, double deepest, Detection detection,
                        Curvature curvature, const std::function<void(const Candidate&)>& visit,
                        const CancellationCheck& check_cancellation) {
  check(pair, prefilter, deepest);
  const std::size_t size = pair.upper.size();
  const double zero = prefilter.min_gap;
  SplinedProfile upper(pair.upper, prefilter.upper_max_abs, pair.spacing, Side::upper);
  SplinedProfile lower(pair.lower, prefilter.lower_max_abs, pair.spacing, Side::lower);
  if (upper.is_flat() && lower.is_flat()) {
    return;  // two flats have no asperities, because 1/R = 0 everywhere
  }
  const bool by_cell = detection == Detection::cell;
  const bool two_convex_spheres = curvature == Curvature::convex && !upper.is_flat() && !lower.is_flat();

  // In gap-minimum detection, the spline of the gap may dip below the gaps at both adjacent grid points.
  const double dip = by_cell ? 0.0 : max_dip(pair.upper, pair.lower);
  constexpr std::size_t chunk_size = 254;
  std::array<unsigned char, chunk_size> marks;
  Candidate candidate{};
  for (const IndexRange& range : ranges_within(pair.upper, pair.lower, prefilter, deepest + dip)) {
    const std::size_t range_begin = by_cell || range.begin == 0 ? range.begin : range.begin - 1;
    const std::size_t range_end = by_cell ? range.end : std::min(range.end, size - 1);
    for (std::size_t begin = range_begin; begin < range_end; begin += chunk_size) {
      check_cancellation();
      const std::size_t end = std::min(begin + chunk_size, range_end);
      const std::size_t count = end - begin;
      upper.compute_derivatives(begin, by_cell ? end : end + 1);
      lower.compute_derivatives(begin, by_cell ? end : end + 1);
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
                                                 : find_site(upper, lower, i, pair.spacing, zero);
        if (!site || !(site->gap <= deepest)) {
          continue;
        }
        if (set_asperity_pair(upper, lower, *site, curvature, candidate.asperity_pair)) {
          const double x = static_cast<double>(i) * pair.spacing + site->offset;
          candidate.index = static_cast<Index>(i);
          candidate.position = Vector3(x, 0.0, site->lower_height);
          candidate.gap = site->gap;
          candidate.radii = radii(candidate.asperity_pair);
          visit(candidate);
        }
      }
    }
  }
}

Candidates candidates(const ProfilePair& pair, double deepest, Curvature curvature,
                      const CancellationCheck& check_cancellation) {
  Candidates result{{}, deepest, pair.spacing};
  for_each_candidate(
      pair, deepest, Detection::gap_minimum, curvature,
      [&](const Candidate& candidate) { result.all.push_back(candidate); }, check_cancellation);
  return result;
}

}  // namespace stiction
