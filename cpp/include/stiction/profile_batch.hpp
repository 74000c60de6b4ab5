// Contact of many pairs of profiles in one call, for example of one set of phases at many fractal dimensions.
// The pairs are the rows of two matrices.
#pragma once

#include "stiction/amplitude.hpp"
#include "stiction/array.hpp"
#include "stiction/cancellation.hpp"
#include "stiction/contact.hpp"

#include <span>
#include <vector>

namespace stiction {

/// Profiles as rows of a matrix [µm], and the height statistics of each profile.
struct ProfileBatch {
  Eigen::Ref<Matrix> heights;
  std::span<const HeightStatistics> statistics;
};

/// Amplitudes [µm] > 0 to which `scale_to_amplitude` scales profiles, and the amplitude measure.
struct Amplitudes {
  Values values;
  AmplitudeMeasure measure;
};

/// Compute the contact sums of each row of `upper` with the same row of `lower`.
/// The profiles are scaled to each amplitude and pressed for each model and approach.
/// The result has the order (row, amplitude, model, approach). The heights are overwritten.
/// Profiles are scaled in place for the last amplitude, which halves the memory traffic.
/// For the other amplitudes, they are scaled into the two rows of `scratch`.
/// Throws as `press` does, and for mismatched shapes and flat profiles.
std::vector<Sums> press_profile_batches(ProfileBatch upper, ProfileBatch lower, double spacing,
                                        const Amplitudes& amplitudes, Values approaches,
                                        std::span<const ContactModel> models, Eigen::Ref<Matrix> scratch,
                                        const CancellationCheck& check_cancellation = {});

}  // namespace stiction
