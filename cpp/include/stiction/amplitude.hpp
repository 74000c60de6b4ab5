// Height statistics of a profile, and scaling of the profile to a given amplitude.
#pragma once

#include "stiction/values.hpp"

#include <array>
#include <limits>
#include <optional>
#include <string_view>

namespace stiction {

/// Measure of the amplitude of a profile: peak-to-valley height, arithmetic mean deviation Ra, or rms deviation Rq.
enum class AmplitudeMeasure { height, ra, rq };

/// Return the amplitude measure named "height", "Ra" or "Rq". Throws std::invalid_argument for any other name.
AmplitudeMeasure amplitude_measure(std::string_view name);

struct HeightStatistics {
  double mean;
  double min;
  double max;
};

/// If every chunk except the last contains a multiple of `lanes` heights, the statistics do not depend on chunk sizes.
class HeightAccumulator {
 public:
  static constexpr std::size_t lanes = 32;

  HeightAccumulator();
  void add(Values heights);
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

/// Return the scaling that gives a profile the amplitude `amplitude` [µm], or std::nullopt if the profile is flat.
std::optional<Scaling> find_scaling(double amplitude, AmplitudeMeasure measure, Values heights,
                                    const HeightStatistics& statistics);

void scale(Values heights, const Scaling& scaling, std::span<double> scaled);

/// Scale `heights` [µm] to zero mean and to the amplitude `amplitude` [µm].
/// If the profile is flat, returns false and leaves the heights unchanged.
bool scale_to_amplitude(Values heights, double amplitude, AmplitudeMeasure measure, std::span<double> scaled);

}  // namespace stiction
