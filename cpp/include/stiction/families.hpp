// Families of profiles pressed together: the rows of two matrices, such as one set of phases at many fractal
// dimensions. What a study does with each pair, in one call.
#pragma once

#include "stiction/amplitude.hpp"
#include "stiction/array.hpp"
#include "stiction/checkpoint.hpp"
#include "stiction/contact.hpp"

#include <span>
#include <vector>

namespace stiction {

/// Profiles as rows [µm], and the level of each.
struct Family {
  Eigen::Ref<Matrix> heights;
  std::span<const Level> levels;
};

/// Amplitudes [µm] > 0 that profiles are scaled to, as `scale_to_amplitude` does it, and by what measure.
struct Amplitudes {
  Values values;
  AmplitudeMeasure measure;
};

/// Each row of `upper` with the same of `lower`, both scaled to each of the amplitudes, and then `press` by each model:
/// a list in the order (row, amplitude, model, approach). The heights are used up: to the last amplitude they are
/// scaled where they are, which moves half as much memory, to others into the two rows of `scratch`. Throws as `press`,
/// and for shapes that do not match and flat profiles.
std::vector<Sums> press_families(Family upper, Family lower, double spacing, const Amplitudes& amplitudes,
                                 Values approaches, std::span<const ContactModel> models, Eigen::Ref<Matrix> scratch,
                                 const Checkpoint& checkpoint = {});

}  // namespace stiction
