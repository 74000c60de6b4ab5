// Contact of two rough profiles: Hanaor, Gan & Einav, Tribol. Int. 93 (2016) 229, Eqs. 4 to 7.
#pragma once

#include "stiction/array.hpp"
#include "stiction/asperity_pair.hpp"
#include "stiction/cancellation.hpp"
#include "stiction/candidates.hpp"
#include "stiction/law.hpp"
#include "stiction/sums.hpp"

#include <vector>

namespace stiction {

struct ContactModel {
  Law law;
  Detection detection = Detection::cell;
  Curvature curvature = Curvature::convex;
  Vector2 direction = {1.0, 0.0};  ///< horizontal unit vector along which the upper surface moves
  Sliding sliding = Sliding::opposing;
};

/// A single contact of two surfaces. Positions are in the coordinates of the lower surface.
struct Contact {
  Index index;      ///< index of the candidate
  Vector3 centre;   ///< centre of the contact [µm]
  Vector3 normal;   ///< unit vector from the lower to the upper surface
  Vector3 tangent;  ///< unit vector of the friction force on the upper surface
  Radii radii;      ///< principal radii of the relative curvature
  Vector2 axes;     ///< semi-axes of the contact patch [µm]; the first is the larger
  Vector3 along;    ///< unit vector along the larger semi-axis; on profiles, this vector is along y
  double overlap;   ///< overlap of the asperities along the normal [µm]
  double force;     ///< normal force [mN]
  double area;      ///< contact area [µm²]
  bool opposing;
};

/// List the contacts at one approach (>= 0) [µm], in the order of their grid points.
/// Throws std::invalid_argument for invalid arguments, and if the approach exceeds `deepest` of the candidates.
std::vector<Contact> contacts(const ProfilePair& pair, double approach, const ContactModel& model,
                              const CancellationCheck& check_cancellation = {});
std::vector<Contact> contacts(const Candidates& candidates, double approach, const ContactModel& model,
                              const CancellationCheck& check_cancellation = {});

/// Compute the contact sums at approaches (>= 0) [µm], which must be strictly increasing.
/// The overload for candidates ignores the detection method and the curvature rule of the model.
std::vector<Sums> press(const ProfilePair& pair, Values approaches, const ContactModel& model,
                        const CancellationCheck& check_cancellation = {});
std::vector<Sums> press(const ProfilePair& pair, const Prefilter& prefilter, Values approaches,
                        const ContactModel& model, const CancellationCheck& check_cancellation = {});
std::vector<Sums> press(const Candidates& candidates, Values approaches, const ContactModel& model,
                        const CancellationCheck& check_cancellation = {});

}  // namespace stiction
