// Amplitude of a profile: height statistics, measures of amplitude, and scaling to a given amplitude.
#pragma once

#include "stiction/values.hpp"

#include <array>
#include <limits>
#include <optional>
#include <string_view>

namespace stiction {

/// Measure of the amplitude of a profile. `height` is the height of the highest point above the lowest point.
/// `ra` is the mean absolute deviation of the heights from their mean, and `rq` the root-mean-square deviation.
enum class AmplitudeMeasure { height, ra, rq };

/// Parse the name of an amplitude measure: "height", "Ra" or "Rq". Throws std::invalid_argument for any other name.
AmplitudeMeasure amplitude_measure(std::string_view name);

/// Mean height, smallest height and largest height of a profile [µm].
struct HeightStatistics {
  double mean;
  double min;
  double max;
};

/// Accumulator of the height statistics of a profile. The profile is added in chunks, from left to right.
/// Each SIMD lane has its own sum, minimum and maximum of the heights that the lane processes.
/// The statistics do not depend on the chunk sizes if every chunk except the last has a multiple of `lanes` heights.
class HeightAccumulator {
 public:
  static constexpr std::size_t lanes = 32;

  HeightAccumulator();
  /// Add the next chunk of heights [µm].
  void add(Values heights);
  /// Return the statistics of all heights that have been added.
  HeightStatistics statistics() const;

 private:
  std::size_t count_ = 0;
  std::array<double, lanes> sums_;
  std::array<double, lanes> minima_;
  std::array<double, lanes> maxima_;
};

/// Linear scaling of heights: scaled = (height - mean) * factor.
struct Scaling {
  double mean;
  double factor;
};

/// Return the scaling that gives a profile the amplitude `amplitude` [µm].
/// Returns nothing for a flat profile, because no factor changes its amplitude.
std::optional<Scaling> find_scaling(double amplitude, AmplitudeMeasure measure, Values heights,
                                    const HeightStatistics& statistics);

/// Write (height - mean) * factor for each height to `scaled`, which must have as many elements as `heights`.
void scale(Values heights, const Scaling& scaling, std::span<double> scaled);

/// Scale `heights` to zero mean and to the amplitude `amplitude` [µm], and write the scaled heights to `scaled`.
/// Returns false for a flat profile, which cannot be scaled.
/// Throws std::invalid_argument if `heights` and `scaled` differ in length.
bool scale_to_amplitude(Values heights, double amplitude, AmplitudeMeasure measure, std::span<double> scaled);

}  // namespace stiction
