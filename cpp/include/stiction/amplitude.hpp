// Amplitude of a profile: height statistics, amplitude measures, and scaling to a given amplitude.
#pragma once

#include "stiction/array.hpp"

#include <array>
#include <limits>
#include <optional>
#include <string_view>

namespace stiction {

/// Definition of the amplitude of a profile. `height` is the highest minus the lowest point.
/// `ra` is the mean absolute deviation from the mean, and `rq` is the root-mean-square deviation.
enum class AmplitudeMeasure { height, ra, rq };

/// Parse a measure: "height", "Ra" or "Rq". Throws std::invalid_argument for any other name.
AmplitudeMeasure amplitude_measure(std::string_view name);

/// Mean, lowest and highest point of a profile [µm].
struct HeightStatistics {
  double mean;
  double min;
  double max;
};

/// Accumulates the height statistics of a profile that arrives in chunks, from left to right.
/// Each SIMD lane has its own sum and extremes.
/// The result does not depend on the chunk sizes if the length of each chunk except the last is a multiple of `lanes`.
class HeightAccumulator {
 public:
  static constexpr std::size_t lanes = 32;

  HeightAccumulator();
  /// Add the next chunk of heights [µm].
  void add(Values heights);
  /// Return the statistics of all heights so far.
  HeightStatistics statistics() const;

 private:
  std::size_t count_ = 0;
  std::array<double, lanes> sums_;
  std::array<double, lanes> minima_;
  std::array<double, lanes> maxima_;
};

/// Scaling of heights: scaled = (height - mean) * factor.
struct Scaling {
  double mean;
  double factor;
};

/// Return the scaling that gives a profile with these statistics the amplitude `amplitude` [µm].
/// Returns nothing for a flat profile, because it cannot be scaled.
std::optional<Scaling> find_scaling(double amplitude, AmplitudeMeasure measure, Values heights,
                                    const HeightStatistics& statistics);

/// Write (height - mean) factor to `scaled`, which has the same length as `heights`.
void scale(Values heights, const Scaling& scaling, std::span<double> scaled);

/// Scale `heights` to zero mean and the amplitude `amplitude` [µm], and write them to `scaled`.
/// Returns false for a flat profile, because it cannot be scaled. Throws std::invalid_argument if the lengths differ.
bool scale_to_amplitude(Values heights, double amplitude, AmplitudeMeasure measure, std::span<double> scaled);

}  // namespace stiction
