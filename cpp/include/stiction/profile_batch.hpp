// Contact of many pairs of profiles in one call, for example of pairs that differ only in their fractal dimension.
// Row i of a matrix of upper profiles and row i of a matrix of lower profiles form a pair.
#pragma once

#include "stiction/amplitude.hpp"
#include "stiction/array.hpp"
#include "stiction/cancellation.hpp"
#include "stiction/contact.hpp"

#include <span>
#include <vector>

namespace stiction {

/// Heights [µm] of profiles, with one profile per row of a matrix, and the height statistics of each profile.
struct ProfileBatch {
  Eigen::Ref<Matrix> heights;
  std::span<const HeightStatistics> statistics;
};

struct Amplitudes {
  Values values;
  AmplitudeMeasure measure;
};

/// Compute contact sums, ordered by pair, then by amplitude, then by model, then by approach.
/// Profiles scaled to the last amplitude overwrite the heights. Other scaled profiles are written to `scratch`.
/// Throws the same exceptions as `press`. Also throws std::invalid_argument if shapes differ or a profile is flat.
std::vector<Sums> press_profile_batches(ProfileBatch upper, ProfileBatch lower, double spacing,
                                        const Amplitudes& amplitudes, Values approaches,
                                        std::span<const ContactModel> models, Eigen::Ref<Matrix> scratch,
                                        const CancellationCheck& check_cancellation = {});

}  // namespace stiction
