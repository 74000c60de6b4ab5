// Load instead of approach: how far two bodies come together under a given normal load.
#pragma once

#include "stiction/areal.hpp"
#include "stiction/array.hpp"
#include "stiction/candidates.hpp"
#include "stiction/checkpoint.hpp"
#include "stiction/contact.hpp"

#include <functional>
#include <vector>

namespace stiction {

/// What a function is at several arguments, which increase.
using ManyValues = std::function<std::vector<double>(Values)>;

/// Where a function rises through levels: for each level the first argument found at which it is not below it, between
/// `left`, where it is, and `right`, where it is not, to a relative `tolerance` of the argument. Where the function
/// jumps over the level, it is the argument behind the jump. By inverse quadratic interpolation or bisection:
/// Chandrupatla, Advances in Engineering Software 28 (1997) 145. All levels take a step together, because a function of
/// many arguments may cost little more than that of one.
std::vector<double> rises_through(const ManyValues& function, Values levels, Values left, Values right,
                                  double tolerance);

/// Approaches [µm] between `left` and `right` at which the normal load of mu0 [-] and tau0 [GPa] rises through loads
/// [mN], to 1e-12. Throws as `press`.
std::vector<double> approaches_at(const ProfilePair& pair, Values loads, Values left, Values right, double mu0,
                                  double tau0, const ContactModel& model, const Checkpoint& checkpoint = {});
std::vector<double> approaches_at(const Candidates& found, Values loads, Values left, Values right, double mu0,
                                  double tau0, const ContactModel& model, const Checkpoint& checkpoint = {});
std::vector<double> approaches_at(const ArealCandidates& found, Values loads, Values left, Values right, double mu0,
                                  double tau0, const ContactModel& model, const Checkpoint& checkpoint = {});

}  // namespace stiction
