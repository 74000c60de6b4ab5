#include "stiction/contact.hpp"

#include "checks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stiction {
namespace {

constexpr double anywhere = std::numeric_limits<double>::infinity();

// Calls visit(index of the approach, touch, verdict) for every approach at which a candidate is a contact, or would be
// one if its centres had not crossed.
template <class Visit>
void visit_touches(const Candidate& candidate, Values approaches, double half_cell, const Visit& visit) {
  const auto first = std::lower_bound(approaches.begin(), approaches.end(), candidate.gap);
  const auto begin = static_cast<std::size_t>(first - approaches.begin());
  const auto visit_all = [&](const auto& encounter) {
    for (std::size_t k = begin; k < approaches.size(); ++k) {
      if (encounter.is_apart(approaches[k])) {
        continue;
      }
      const Touch touch = encounter.at(approaches[k]);
      const Verdict verdict = judge(touch, half_cell);
      if (verdict != Verdict::no_contact) {
        visit(k, touch, verdict);
      }
    }
  };
  std::visit(visit_all, candidate.encounter);
}

template <class L>
void add_candidate(const Candidate& candidate, Values approaches, double half_cell, double spacing, const L& law,
                   const Vector2& direction, Sliding sliding, std::vector<Sums>& sums) {
  visit_touches(candidate, approaches, half_cell, [&](std::size_t k, const Touch& touch, Verdict verdict) {
    if (verdict == Verdict::crossed) {
      sums[k].crossed_count += 1;
    } else {
      sums[k].add(touch, candidate.radii, law(touch.overlap, candidate.radii), direction, sliding, spacing);
    }
  });
}

template <class L>
void list_candidate(const Candidate& candidate, double approach, double half_cell, const L& law,
                    const Vector2& direction, std::vector<Contact>& rows) {
  visit_touches(candidate, {&approach, 1}, half_cell, [&](std::size_t, const Touch& touch, Verdict verdict) {
    if (verdict == Verdict::crossed) {
      return;
    }
    const auto [force, area] = law(touch.overlap, candidate.radii);
    rows.push_back({candidate.index, candidate.position + touch.centre, touch.normal, tangent(touch.normal, direction),
                    candidate.radii, law.semi_axes(touch.overlap, candidate.radii), Vector3::UnitY(), touch.overlap,
                    force, area, opposes(touch.normal, direction)});
  });
}

void check(Values approaches, double deepest, const ContactModel& model) {
  check_approaches(approaches, deepest);
  check(model.law);
  check_direction(model.direction);
}

double half_cell(const ProfilePair& pair, const ContactModel& model) {
  return model.detection == Detection::cell ? 0.5 * pair.spacing : anywhere;
}

}  // namespace

std::vector<Contact> contacts(const ProfilePair& pair, double approach, const ContactModel& model,
                              const Checkpoint& checkpoint) {
  check({&approach, 1}, anywhere, model);
  std::vector<Contact> rows;
  const auto list_with = [&](const auto& law) {
    for_each_candidate(
        pair, approach, model.detection, model.curvature,
        [&](const Candidate& candidate) {
          list_candidate(candidate, approach, half_cell(pair, model), law, model.direction, rows);
        },
        checkpoint);
  };
  std::visit(list_with, model.law);
  return rows;
}

std::vector<Contact> contacts(const Candidates& found, double approach, const ContactModel& model,
                              const Checkpoint& checkpoint) {
  check({&approach, 1}, found.deepest, model);
  std::vector<Contact> rows;
  const auto list_with = [&](const auto& law) {
    for (const Candidate& candidate : found.all) {
      checkpoint();
      list_candidate(candidate, approach, anywhere, law, model.direction, rows);
    }
  };
  std::visit(list_with, model.law);
  return rows;
}

std::vector<Sums> press(const ProfilePair& pair, Values approaches, const ContactModel& model,
                        const Checkpoint& checkpoint) {
  return press(pair, screen(pair), approaches, model, checkpoint);
}

std::vector<Sums> press(const ProfilePair& pair, const Screening& screening, Values approaches,
                        const ContactModel& model, const Checkpoint& checkpoint) {
  check(approaches, anywhere, model);
  std::vector<Sums> sums(approaches.size());
  const auto press_with = [&](const auto& law) {
    for_each_candidate(
        pair, screening, approaches.back(), model.detection, model.curvature,
        [&](const Candidate& candidate) {
          add_candidate(candidate, approaches, half_cell(pair, model), pair.spacing, law, model.direction,
                        model.sliding, sums);
        },
        checkpoint);
  };
  std::visit(press_with, model.law);
  return sums;
}

std::vector<Sums> press(const Candidates& found, Values approaches, const ContactModel& model,
                        const Checkpoint& checkpoint) {
  check(approaches, found.deepest, model);
  std::vector<Sums> sums(approaches.size());
  const auto press_with = [&](const auto& law) {
    for (const Candidate& candidate : found.all) {
      checkpoint();
      if (candidate.gap <= approaches.back()) {
        add_candidate(candidate, approaches, anywhere, found.spacing, law, model.direction, model.sliding, sums);
      }
    }
  };
  std::visit(press_with, model.law);
  return sums;
}

}  // namespace stiction
