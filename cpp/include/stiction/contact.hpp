// Two rough bodies pressed together: Hanaor, Gan & Einav, Tribol. Int. 93 (2016) 229, Eqs. 4 to 7. Candidates, judged
// at an approach, are contacts; a law says what each carries; sums of these are what a pair carries.
#pragma once

#include "stiction/array.hpp"
#include "stiction/candidates.hpp"
#include "stiction/checkpoint.hpp"
#include "stiction/encounter.hpp"
#include "stiction/law.hpp"
#include "stiction/sums.hpp"

#include <vector>

namespace stiction {

/// How two bodies are pressed together.
struct ContactModel {
  Law law;
  Detection detection = Detection::cell;
  Curvature curvature = Curvature::convex;
  Vector2 direction = {1.0, 0.0};  ///< where the upper body is about to move: a horizontal unit vector
  Sliding sliding = Sliding::opposing;
};

/// One contact. Positions are in the frame of the lower body.
struct Contact {
  Index index;      ///< of its candidate
  Vector3 centre;   ///< [µm]
  Vector3 normal;   ///< unit vector from the lower to the upper body
  Vector3 tangent;  ///< unit vector of the friction on the upper body
  Radii radii;      ///< of the relative curvature
  Vector2 axes;     ///< semi-axes of the patch [µm], the larger first
  Vector3 along;    ///< unit vector of the larger one, on profiles y
  double overlap;   ///< [µm]
  double force;     ///< normal force [mN]
  double area;      ///< [µm²]
  bool opposing;    ///< its normal force opposes the motion
};

/// Every contact at one approach [µm] >= 0, in the order of the grid. Throws std::invalid_argument for what is out of
/// range, as `for_each_candidate` and `check` do, and where the approach is beyond the candidates' deepest.
std::vector<Contact> contacts(const ProfilePair& pair, double approach, const ContactModel& model,
                              const Checkpoint& checkpoint = {});
std::vector<Contact> contacts(const Candidates& found, double approach, const ContactModel& model,
                              const Checkpoint& checkpoint = {});

/// The sums at approaches [µm], which are >= 0 and strictly increasing. Otherwise as `contacts`. Candidates know what
/// they were found by: of a model, they take the law and the direction. A pair may have been screened before.
std::vector<Sums> press(const ProfilePair& pair, Values approaches, const ContactModel& model,
                        const Checkpoint& checkpoint = {});
std::vector<Sums> press(const ProfilePair& pair, const Screening& screening, Values approaches,
                        const ContactModel& model, const Checkpoint& checkpoint = {});
std::vector<Sums> press(const Candidates& found, Values approaches, const ContactModel& model,
                        const Checkpoint& checkpoint = {});

}  // namespace stiction
