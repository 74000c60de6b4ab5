#include "areal_edge.hpp"
#include "areal_overlaps.hpp"
#include "checks.hpp"
#include "multiversion.hpp"
#include "stiction/areal.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>

namespace stiction {
namespace {

using std::numbers::pi;

double elastic_area(const Ellipse& ellipse, double overlap) {
  return pi * std::sqrt(ellipse.major * ellipse.minor) * overlap;
}

template <class AnyLaw>
ForceArea force_and_area(const AnyLaw& law, const ArealCandidate& candidate, double overlap) {
  return law(overlap, candidate.radii);
}

ForceArea force_and_area(const HertzSphere& law, const ArealCandidate& candidate, double overlap) {
  return {4.0 / 3.0 * law.effective_modulus * std::sqrt(candidate.ellipse.force_radius * overlap) * overlap,
          elastic_area(candidate.ellipse, overlap)};
}

// Contact area divided by the area of the elastic contact ellipse. Yielding changes the ellipse's size, not its shape.
template <class AnyLaw>
double relative_area(const AnyLaw&, const ArealCandidate& candidate, double overlap, double area) {
  return area / elastic_area(candidate.ellipse, overlap);
}

double relative_area(const HertzSphere&, const ArealCandidate&, double, double) { return 1.0; }

void reject_cylinders(const Law& law) {
  if (std::holds_alternative<HertzCylinder>(law)) {
    throw std::invalid_argument(
        "law must be a sphere law, got hertz-cylinder; use hertz-sphere, because contacts of surfaces are ellipses");
  }
}

// The sums over contacts contain forces times -s·n, -c·n, t_z, -s·t and -c·t, and areas times t_z, -s·t and -c·t.
// s is the direction of sliding, c the lateral direction, n the contact normal and t the tangent of the friction force.
constexpr std::size_t num_factors = 5;
constexpr std::size_t num_normal_factors = 2;
constexpr std::size_t num_directed_sums = 2 * num_factors - num_normal_factors;

STICTION_MULTIVERSION
void compute_factors(const Vector3& normal, const double* directions_xy, std::size_t direction_count, bool all,
                     double* factors) {
  const double x = normal.x();
  const double y = normal.y();
  const double z = normal.z();
  for (std::size_t d = 0; d < direction_count; ++d) {
    const double along = x * directions_xy[d] + y * directions_xy[direction_count + d];
    const double across = y * directions_xy[d] - x * directions_xy[direction_count + d];
    const double length = std::sqrt(z * z + across * across);
    const double slope_component = along / length;
    const double slides = (all | (along < 0.0)) ? 1.0 : 0.0;
    factors[d] = -along * slides;
    factors[direction_count + d] = -across * slides;
    factors[2 * direction_count + d] = slope_component * z * slides;
    factors[3 * direction_count + d] = length * slides;
    factors[4 * direction_count + d] = -slope_component * across * slides;
  }
}

constexpr std::size_t contacts_per_block = 16;

// For approaches k >= `begin`, add Σ_i factors(i, m, d) values(i, k) over the contacts i of a block to sums(d, m, k).
// values(i, k) is the force on contact i at approach k in the first `num_factors` sums, and its area in the other sums.
// `begin` and `steps` are multiples of every SIMD width.
template <std::size_t Width>
STICTION_INLINE void add_block_kernel(const double* factors, const double* force, const double* area,
                                      std::size_t contacts, std::size_t direction_count, std::size_t begin,
                                      std::size_t steps, double* sums) {
  for (std::size_t d = 0; d < direction_count; ++d) {
    for (std::size_t k = begin; k < steps; k += Width) {
      double* sum = sums + d * num_directed_sums * steps + k;
      Pack<Width> total[num_directed_sums];
      for (std::size_t m = 0; m < num_directed_sums; ++m) {
        total[m] = load<Width>(sum + m * steps);
      }
      for (std::size_t i = 0; i < contacts; ++i) {
        const double* contact_factors = factors + i * num_factors * direction_count + d;
        const Pack<Width> forces = load<Width>(force + i * steps + k);
        const Pack<Width> areas = load<Width>(area + i * steps + k);
        for (std::size_t m = 0; m < num_factors; ++m) {
          total[m] += contact_factors[m * direction_count] * forces;
        }
        for (std::size_t m = num_normal_factors; m < num_factors; ++m) {
          total[m + num_factors - num_normal_factors] += contact_factors[m * direction_count] * areas;
        }
      }
      for (std::size_t m = 0; m < num_directed_sums; ++m) {
        store<Width>(total[m], sum + m * steps);
      }
    }
  }
}

STICTION_KERNEL(add_block,
                (const double* factors, const double* force, const double* area, std::size_t contacts,
                 std::size_t direction_count, std::size_t begin, std::size_t steps, double* sums),
                (factors, force, area, contacts, direction_count, begin, steps, sums))

}  // namespace

std::vector<Contact> contacts(const ArealCandidates& candidates, double approach, const Law& law,
                              const Vector2& direction) {
  check_approaches({&approach, 1}, candidates.deepest);
  check(law);
  reject_cylinders(law);
  check_direction(direction);
  std::vector<Contact> result;
  const auto add_contacts = [&](const auto& any_law) {
    for (const ArealCandidate& candidate : candidates.all) {
      const double overlap = candidate.overlap(approach);
      if (!(overlap > 0.0)) {
        continue;
      }
      auto [force, area] = force_and_area(any_law, candidate, overlap);
      const double size = overlap * relative_area(any_law, candidate, overlap, area);
      if (size > candidate.edge_overlap) {
        const InsideFractions inside = MapEdges(candidates, candidate).fractions_inside(size);
        force *= inside.force;
        area *= inside.area;
      }
      // The semi-axes are scaled by one factor, so that the ellipse has the area of its part inside the map.
      const double scale = area / (pi * std::sqrt(candidate.ellipse.major * candidate.ellipse.minor));
      result.push_back({candidate.row * candidates.columns + candidate.column,
                        candidate.position - 0.5 * overlap * candidate.normal, candidate.normal,
                        tangent(candidate.normal, direction), candidate.radii,
                        Vector2(std::sqrt(candidate.ellipse.major * scale), std::sqrt(candidate.ellipse.minor * scale)),
                        candidate.along, overlap, force, area, opposes(candidate.normal, direction)});
    }
  };
  std::visit(add_contacts, law);
  return result;
}

std::vector<ArealSums> press(const ArealCandidates& candidates, Values approaches, const Law& law,
                             std::span<const Vector2> directions, Sliding sliding,
                             const CancellationCheck& check_cancellation) {
  check_approaches(approaches, candidates.deepest);
  check(law);
  reject_cylinders(law);
  if (directions.empty()) {
    throw std::invalid_argument("directions must not be empty");
  }
  for (const Vector2& direction : directions) {
    check_direction(direction);
  }
  const std::size_t steps = approaches.size();
  const std::size_t direction_count = directions.size();
  const double max_spacing = candidates.spacing.maxCoeff();
  const std::vector<std::size_t> overlapping = first_overlaps(candidates.all, approaches, check_cancellation);
  std::vector<ArealSums> common(steps);
  const auto whole_packs = [](std::size_t count) { return count / widest_pack * widest_pack; };
  const std::size_t padded_steps = whole_packs(steps + widest_pack - 1);
  std::vector<double> sums(direction_count * num_directed_sums * padded_steps, 0.0);
  std::vector<double> force(contacts_per_block * padded_steps);
  std::vector<double> area(contacts_per_block * padded_steps);
  std::vector<double> factors(contacts_per_block * num_factors * direction_count);
  std::vector<double> directions_xy(2 * direction_count);  // x components of all directions, then all y components
  for (std::size_t d = 0; d < direction_count; ++d) {
    directions_xy[d] = directions[d].x();
    directions_xy[direction_count + d] = directions[d].y();
  }
  struct Start {
    std::size_t candidate;
    std::size_t begin;
  };
  std::vector<Start> starts;
  for (std::size_t i = 0; i < candidates.all.size(); ++i) {
    const std::size_t begin = first_contact_step(candidates.all[i], approaches);
    if (begin < steps) {
      starts.push_back({i, begin});
    }
  }
  std::stable_sort(starts.begin(), starts.end(), [](const Start& a, const Start& b) { return a.begin < b.begin; });
  std::size_t pending = 0;
  std::size_t earliest = 0;
  const auto add_pending = [&] {
    check_cancellation();
    add_block(factors.data(), force.data(), area.data(), pending, direction_count, whole_packs(earliest), padded_steps,
              sums.data());
    std::fill(force.begin(), force.end(), 0.0);
    std::fill(area.begin(), area.end(), 0.0);
    pending = 0;
  };
  const auto add_contacts = [&](const auto& any_law) {
    for (const auto [i, begin] : starts) {
      const ArealCandidate& candidate = candidates.all[i];
      const double radius = candidate.radii.mean();
      earliest = pending == 0 ? begin : earliest;
      std::optional<MapEdges> edges;
      for (std::size_t k = begin; k < steps; ++k) {
        const double overlap = candidate.overlap(approaches[k]);
        ForceArea force_area = force_and_area(any_law, candidate, overlap);
        const double size = overlap * relative_area(any_law, candidate, overlap, force_area.area);
        const bool is_cut = size > candidate.edge_overlap;
        if (is_cut) {
          edges = edges ? edges : MapEdges(candidates, candidate);
          const InsideFractions inside = edges->fractions_inside(size);
          force_area.force *= inside.force;
          force_area.area *= inside.area;
        }
        force[pending * padded_steps + k] = force_area.force;
        area[pending * padded_steps + k] = force_area.area;
        const double load = common[k].add(candidate.normal, overlap, radius, force_area, max_spacing);
        common[k].load_overlapping += k >= overlapping[i] ? load : 0.0;
        common[k].load_at_edge += is_cut ? load : 0.0;
      }
      compute_factors(candidate.normal, directions_xy.data(), direction_count, sliding == Sliding::all,
                      &factors[pending * num_factors * direction_count]);
      pending += 1;
      if (pending == contacts_per_block) {
        add_pending();
      }
    }
    add_pending();
  };
  std::visit(add_contacts, law);
  const auto count_within = [](const std::vector<double>& gaps, double approach) {
    return std::upper_bound(gaps.begin(), gaps.end(), approach) - gaps.begin();
  };
  for (std::size_t k = 0; k < steps; ++k) {
    common[k].grid_minimum_count = count_within(candidates.grid_minima, approaches[k]);
    common[k].unanswered_count = count_within(candidates.unanswered, approaches[k]);
  }
  std::vector<ArealSums> result;
  result.reserve(directions.size() * steps);
  for (std::size_t d = 0; d < directions.size(); ++d) {
    const auto sum = [&](std::size_t m, std::size_t k) { return sums[(d * num_directed_sums + m) * padded_steps + k]; };
    for (std::size_t k = 0; k < steps; ++k) {
      ArealSums row = common[k];
      row.tangential_elastic = sum(0, k);
      row.lateral_elastic = sum(1, k);
      row.normal_frictional = sum(2, k);
      row.tangential_frictional = sum(3, k);
      row.lateral_frictional = sum(4, k);
      row.normal_adhesive = sum(5, k);
      row.tangential_adhesive = sum(6, k);
      row.lateral_adhesive = sum(7, k);
      result.push_back(row);
    }
  }
  return result;
}

std::vector<ArealSums> press(const ArealCandidates& candidates, Values approaches, const ContactModel& model,
                             const CancellationCheck& check_cancellation) {
  return press(candidates, approaches, model.law, std::span(&model.direction, 1), model.sliding, check_cancellation);
}

}  // namespace stiction
