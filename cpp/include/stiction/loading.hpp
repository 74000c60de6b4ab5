// Load control: approaches of two surfaces at given normal loads.
#pragma once

#include "stiction/areal.hpp"
#include "stiction/array.hpp"
#include "stiction/cancellation.hpp"
#include "stiction/candidates.hpp"
#include "stiction/contact.hpp"

#include <functional>
#include <vector>

namespace stiction {

/// Function that accepts several arguments in increasing order, and returns its value at each argument.
using BatchFunction = std::function<std::vector<double>(Values)>;

/// Find, for each of the given levels, the argument at which a function first reaches the level from below.
/// The function must be below the level at the argument `left`, and at or above the level at the argument `right`.
/// If the function jumps from below the level to above the level, the result is the argument just after the jump.
/// Method: inverse quadratic interpolation and bisection (Chandrupatla, Adv. Eng. Software 28 (1997) 145).
std::vector<double> find_crossings(const BatchFunction& function, Values levels, Values left, Values right,
                                   double tolerance);

/// Find the approaches [µm] between `left` and `right` at which the normal load reaches `loads` [mN].
/// The normal load depends on mu0 [-] and tau0 [GPa]. Each approach is found to a relative tolerance of 1e-12.
std::vector<double> approaches_at(const ProfilePair& pair, Values loads, Values left, Values right, double mu0,
                                  double tau0, const ContactModel& model,
                                  const CancellationCheck& check_cancellation = {});
std::vector<double> approaches_at(const Candidates& candidates, Values loads, Values left, Values right, double mu0,
                                  double tau0, const ContactModel& model,
                                  const CancellationCheck& check_cancellation = {});
std::vector<double> approaches_at(const ArealCandidates& candidates, Values loads, Values left, Values right,
                                  double mu0, double tau0, const ContactModel& model,
                                  const CancellationCheck& check_cancellation = {});

}  // namespace stiction
