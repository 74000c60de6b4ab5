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

// ---- What a contact carries -----------------------------------------------------------------------------------------

double elastic_area(const Ellipse& ellipse, double overlap) {
  return pi * std::sqrt(ellipse.major * ellipse.minor) * overlap;
}

// Laws of spheres take the one of the mean radius, unless they say better.
template <class AnyLaw>
ForceArea carried(const AnyLaw& law, const ArealCandidate& candidate, double overlap) {
  return law(overlap, candidate.radii);
}

ForceArea carried(const HertzSphere& law, const ArealCandidate& candidate, double overlap) {
  return {4.0 / 3.0 * law.effective_modulus * std::sqrt(candidate.ellipse.stiff * overlap) * overlap,
          elastic_area(candidate.ellipse, overlap)};
}

// What yields spreads in proportion: area over that of the elastic ellipse.
template <class AnyLaw>
double spread(const AnyLaw&, const ArealCandidate& candidate, double overlap, double area) {
  return area / elastic_area(candidate.ellipse, overlap);
}

double spread(const HertzSphere&, const ArealCandidate&, double, double) { return 1.0; }

void refuse_cylinders(const Law& law) {
  if (std::holds_alternative<HertzCylinder>(law)) {
    throw std::invalid_argument(
        "law hertz-cylinder is of parallel cylinders, and contacts of surfaces are ellipses: take hertz-sphere");
  }
}

// ---- Sums that depend on the direction ------------------------------------------------------------------------------

// -s·n, -c·n, t_z, -s·t and -c·t of a sliding contact, c being the lateral direction: multiples of force, and those of
// the tangent t of area as well.
constexpr std::size_t of_force = 5;
constexpr std::size_t of_normal = 2;
constexpr std::size_t directed_sums = 2 * of_force - of_normal;

// As `pull` has it, of all directions; 0 where the contact does not slide.
STICTION_MULTIVERSION
void pull_along(const Vector3& normal, const double* towards, std::size_t ways, bool all, double* pulls) {
  const double x = normal.x();
  const double y = normal.y();
  const double z = normal.z();
  for (std::size_t d = 0; d < ways; ++d) {
    const double along = x * towards[d] + y * towards[ways + d];
    const double across = y * towards[d] - x * towards[ways + d];
    const double length = std::sqrt(z * z + across * across);
    const double drawn = along / length;
    const double share = (all | (along < 0.0)) ? 1.0 : 0.0;
    pulls[d] = -along * share;
    pulls[ways + d] = -across * share;
    pulls[2 * ways + d] = drawn * z * share;
    pulls[3 * ways + d] = length * share;
    pulls[4 * ways + d] = -drawn * across * share;
  }
}

constexpr std::size_t block = 16;  // contacts that are added together

// sums(d, m, k) += Σ_i pulls(i, m, d) values(i, k) over the contacts i of a block, force for the first sums m and area
// for the others, from the step `begin` on. Both numbers of steps are a whole number of packs of any width.
template <std::size_t Width>
STICTION_INLINE void add_block_kernel(const double* pulls, const double* force, const double* area,
                                      std::size_t contacts, std::size_t ways, std::size_t begin, std::size_t steps,
                                      double* sums) {
  for (std::size_t d = 0; d < ways; ++d) {
    for (std::size_t k = begin; k < steps; k += Width) {
      double* sum = sums + d * directed_sums * steps + k;
      Pack<Width> total[directed_sums];
      for (std::size_t m = 0; m < directed_sums; ++m) {
        total[m] = load<Width>(sum + m * steps);
      }
      for (std::size_t i = 0; i < contacts; ++i) {
        const double* by = pulls + i * of_force * ways + d;
        const Pack<Width> pushing = load<Width>(force + i * steps + k);
        const Pack<Width> touching = load<Width>(area + i * steps + k);
        for (std::size_t m = 0; m < of_force; ++m) {
          total[m] += by[m * ways] * pushing;
        }
        for (std::size_t m = of_normal; m < of_force; ++m) {
          total[m + of_force - of_normal] += by[m * ways] * touching;
        }
      }
      for (std::size_t m = 0; m < directed_sums; ++m) {
        store<Width>(total[m], sum + m * steps);
      }
    }
  }
}

STICTION_KERNEL(add_block,
                (const double* pulls, const double* force, const double* area, std::size_t contacts, std::size_t ways,
                 std::size_t begin, std::size_t steps, double* sums),
                (pulls, force, area, contacts, ways, begin, steps, sums))

}  // namespace

std::vector<Contact> contacts(const ArealCandidates& found, double approach, const Law& law, const Vector2& direction) {
  check_approaches({&approach, 1}, found.deepest);
  check(law);
  refuse_cylinders(law);
  check_direction(direction);
  std::vector<Contact> result;
  const auto with = [&](const auto& one_law) {
    for (const ArealCandidate& one : found.all) {
      const double overlap = one.overlap(approach);
      if (!(overlap > 0.0)) {
        continue;
      }
      auto [force, area] = carried(one_law, one, overlap);
      const double size = overlap * spread(one_law, one, overlap, area);
      if (size > one.room) {
        const Inside inside = Edges(found, one).inside(size);
        force *= inside.force;
        area *= inside.area;
      }
      // Of the like ellipse with the area that is inside.
      const double scale = area / (pi * std::sqrt(one.ellipse.major * one.ellipse.minor));
      result.push_back({one.row * found.columns + one.column, one.position - 0.5 * overlap * one.normal, one.normal,
                        tangent(one.normal, direction), one.radii,
                        Vector2(std::sqrt(one.ellipse.major * scale), std::sqrt(one.ellipse.minor * scale)), one.along,
                        overlap, force, area, opposes(one.normal, direction)});
    }
  };
  std::visit(with, law);
  return result;
}

std::vector<ArealSums> press(const ArealCandidates& found, Values approaches, const Law& law,
                             std::span<const Vector2> directions, Sliding sliding, const Checkpoint& checkpoint) {
  check_approaches(approaches, found.deepest);
  check(law);
  refuse_cylinders(law);
  if (directions.empty()) {
    throw std::invalid_argument("direction is empty, at least one is needed");
  }
  for (const Vector2& direction : directions) {
    check_direction(direction);
  }
  const std::size_t steps = approaches.size();
  const std::size_t ways = directions.size();
  const double widest = found.spacing.maxCoeff();
  const std::vector<std::size_t> overlapping = first_overlaps(found.all, approaches, checkpoint);
  std::vector<ArealSums> common(steps);  // what all directions share
  const auto whole_packs = [](std::size_t count) { return count / widest_pack * widest_pack; };
  const std::size_t packed = whole_packs(steps + widest_pack - 1);
  std::vector<double> sums(ways * directed_sums * packed, 0.0);
  std::vector<double> force(block * packed);
  std::vector<double> area(block * packed);
  std::vector<double> pulls(block * of_force * ways);
  std::vector<double> towards(2 * ways);  // x of all directions, then y
  for (std::size_t d = 0; d < ways; ++d) {
    towards[d] = directions[d].x();
    towards[ways + d] = directions[d].y();
  }
  // The first to touch first, so that those that are added together begin at about one step.
  struct Touching {
    std::size_t candidate;
    std::size_t begin;
  };
  std::vector<Touching> touching;
  for (std::size_t i = 0; i < found.all.size(); ++i) {
    const std::size_t begin = first_step(found.all[i], approaches);
    if (begin < steps) {
      touching.push_back({i, begin});
    }
  }
  std::stable_sort(touching.begin(), touching.end(),
                   [](const Touching& a, const Touching& b) { return a.begin < b.begin; });
  std::size_t waiting = 0;
  std::size_t earliest = 0;
  const auto add_waiting = [&] {
    checkpoint();
    add_block(pulls.data(), force.data(), area.data(), waiting, ways, whole_packs(earliest), packed, sums.data());
    std::fill(force.begin(), force.end(), 0.0);
    std::fill(area.begin(), area.end(), 0.0);
    waiting = 0;
  };
  const auto with = [&](const auto& one_law) {
    for (const auto [i, begin] : touching) {
      const ArealCandidate& one = found.all[i];
      const double radius = one.radii.mean();
      earliest = waiting == 0 ? begin : earliest;
      std::optional<Edges> edges;
      for (std::size_t k = begin; k < steps; ++k) {
        const double overlap = one.overlap(approaches[k]);
        ForceArea has = carried(one_law, one, overlap);
        const double size = overlap * spread(one_law, one, overlap, has.area);
        const bool cut = size > one.room;
        if (cut) {
          edges = edges ? edges : Edges(found, one);
          const Inside inside = edges->inside(size);
          has.force *= inside.force;
          has.area *= inside.area;
        }
        force[waiting * packed + k] = has.force;
        area[waiting * packed + k] = has.area;
        const double load = common[k].add(one.normal, overlap, radius, has, widest);
        common[k].load_overlapping += k >= overlapping[i] ? load : 0.0;
        common[k].load_at_edge += cut ? load : 0.0;
      }
      pull_along(one.normal, towards.data(), ways, sliding == Sliding::all, &pulls[waiting * of_force * ways]);
      waiting += 1;
      if (waiting == block) {
        add_waiting();
      }
    }
    add_waiting();
  };
  std::visit(with, law);
  const auto within = [](const std::vector<double>& gaps, double approach) {
    return std::upper_bound(gaps.begin(), gaps.end(), approach) - gaps.begin();
  };
  for (std::size_t k = 0; k < steps; ++k) {
    common[k].grid_minimum_count = within(found.grid_minima, approaches[k]);
    common[k].unanswered_count = within(found.unanswered, approaches[k]);
  }
  std::vector<ArealSums> result;
  result.reserve(directions.size() * steps);
  for (std::size_t d = 0; d < directions.size(); ++d) {
    const auto sum = [&](std::size_t m, std::size_t k) { return sums[(d * directed_sums + m) * packed + k]; };
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

std::vector<ArealSums> press(const ArealCandidates& found, Values approaches, const ContactModel& model,
                             const Checkpoint& checkpoint) {
  return press(found, approaches, model.law, std::span(&model.direction, 1), model.sliding, checkpoint);
}

}  // namespace stiction
