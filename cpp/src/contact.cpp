#include "stiction/contact.hpp"

#include "checks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stiction {
namespace {

constexpr double unlimited = std::numeric_limits<double>::infinity();

// Call `visit` at each approach at which the contact point of the candidate has the class `contact` or `crossed`.
template <class Visit>
void visit_contact_points(const Candidate& candidate, Values approaches, double half_cell, const Visit& visit) {
  const auto first = std::lower_bound(approaches.begin(), approaches.end(), candidate.gap);
  const auto begin = static_cast<std::size_t>(first - approaches.begin());
  const auto visit_all = [&](const auto& asperity_pair) {
    for (std::size_t k = begin; k < approaches.size(); ++k) {
      if (asperity_pair.is_separated(approaches[k])) {
        continue;
      }
      const ContactPoint contact_point = asperity_pair.contact_at(approaches[k]);
      const ContactClass contact_class = classify(contact_point, half_cell);
      if (contact_class != ContactClass::no_contact) {
        visit(k, contact_point, contact_class);
      }
    }
  };
  std::visit(visit_all, candidate.asperity_pair);
}

template <class ContactLaw>
void add_candidate(const Candidate& candidate, Values approaches, double half_cell, double spacing,
                   const ContactLaw& law, const Vector2& direction, Sliding sliding, std::vector<Sums>& sums) {
  visit_contact_points(candidate, approaches, half_cell,
                       [&](std::size_t k, const ContactPoint& contact_point, ContactClass contact_class) {
                         if (contact_class == ContactClass::crossed) {
                           sums[k].crossed_count += 1;
                         } else {
                           sums[k].add(contact_point, candidate.radii, law(contact_point.overlap, candidate.radii),
                                       direction, sliding, spacing);
                         }
                       });
}

template <class ContactLaw>
void list_candidate(const Candidate& candidate, double approach, double half_cell, const ContactLaw& law,
                    const Vector2& direction, std::vector<Contact>& result) {
  visit_contact_points(
      candidate, {&approach, 1}, half_cell,
      [&](std::size_t, const ContactPoint& contact_point, ContactClass contact_class) {
        if (contact_class == ContactClass::crossed) {
          return;
        }
        const auto [force, area] = law(contact_point.overlap, candidate.radii);
        result.push_back({candidate.index, candidate.position + contact_point.centre, contact_point.normal,
                          tangent(contact_point.normal, direction), candidate.radii,
                          law.semi_axes(contact_point.overlap, candidate.radii), Vector3::UnitY(),
                          contact_point.overlap, force, area, opposes(contact_point.normal, direction)});
      });
}

void check(Values approaches, double deepest, const ContactModel& model) {
  check_approaches(approaches, deepest);
  check(model.law);
  check_direction(model.direction);
}

double half_cell(const ProfilePair& pair, const ContactModel& model) {
  return model.detection == Detection::cell ? 0.5 * pair.spacing : unlimited;
}

}  // namespace

std::vector<Contact> contacts(const ProfilePair& pair, double approach, const ContactModel& model,
                              const CancellationCheck& check_cancellation) {
  check({&approach, 1}, unlimited, model);
  std::vector<Contact> result;
  const auto list_contacts = [&](const auto& law) {
    for_each_candidate(
        pair, approach, model.detection, model.curvature,
        [&](const Candidate& candidate) {
          list_candidate(candidate, approach, half_cell(pair, model), law, model.direction, result);
        },
        check_cancellation);
  };
  std::visit(list_contacts, model.law);
  return result;
}

std::vector<Contact> contacts(const Candidates& candidates, double approach, const ContactModel& model,
                              const CancellationCheck& check_cancellation) {
  check({&approach, 1}, candidates.deepest, model);
  std::vector<Contact> result;
  const auto list_contacts = [&](const auto& law) {
    for (const Candidate& candidate : candidates.all) {
      check_cancellation();
      list_candidate(candidate, approach, unlimited, law, model.direction, result);
    }
  };
  std::visit(list_contacts, model.law);
  return result;
}

std::vector<Sums> press(const ProfilePair& pair, Values approaches, const ContactModel& model,
                        const CancellationCheck& check_cancellation) {
  return press(pair, run_prefilter(pair), approaches, model, check_cancellation);
}

std::vector<Sums> press(const ProfilePair& pair, const Prefilter& prefilter, Values approaches,
                        const ContactModel& model, const CancellationCheck& check_cancellation) {
  check(approaches, unlimited, model);
  std::vector<Sums> sums(approaches.size());
  const auto add_contacts = [&](const auto& law) {
    for_each_candidate(
        pair, prefilter, approaches.back(), model.detection, model.curvature,
        [&](const Candidate& candidate) {
          add_candidate(candidate, approaches, half_cell(pair, model), pair.spacing, law, model.direction,
                        model.sliding, sums);
        },
        check_cancellation);
  };
  std::visit(add_contacts, model.law);
  return sums;
}

std::vector<Sums> press(const Candidates& candidates, Values approaches, const ContactModel& model,
                        const CancellationCheck& check_cancellation) {
  check(approaches, candidates.deepest, model);
  std::vector<Sums> sums(approaches.size());
  const auto add_contacts = [&](const auto& law) {
    for (const Candidate& candidate : candidates.all) {
      check_cancellation();
      if (candidate.gap <= approaches.back()) {
        add_candidate(candidate, approaches, unlimited, candidates.spacing, law, model.direction, model.sliding, sums);
      }
    }
  };
  std::visit(add_contacts, model.law);
  return sums;
}

}  // namespace stiction
