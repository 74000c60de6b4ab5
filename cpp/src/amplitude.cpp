#include "stiction/amplitude.hpp"

#include "multiversion.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

namespace stiction {
namespace {

STICTION_MULTIVERSION
void accumulate_heights(const double* heights, std::size_t size, double* sums, double* minima, double* maxima) {
  constexpr std::size_t lanes = HeightAccumulator::lanes;
  double sum[lanes];
  double min[lanes];
  double max[lanes];
  std::copy_n(sums, lanes, sum);
  std::copy_n(minima, lanes, min);
  std::copy_n(maxima, lanes, max);
  const auto add = [&](double height, std::size_t lane) {
    sum[lane] += height;
    min[lane] = height < min[lane] ? height : min[lane];
    max[lane] = height > max[lane] ? height : max[lane];
  };
  std::size_t i = 0;
  for (; i + lanes <= size; i += lanes) {
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      add(heights[i + lane], lane);
    }
  }
  for (; i < size; ++i) {
    add(heights[i], i % lanes);
  }
  std::copy_n(sum, lanes, sums);
  std::copy_n(min, lanes, minima);
  std::copy_n(max, lanes, maxima);
}

STICTION_MULTIVERSION
void scale_heights(const double* heights, std::size_t size, double mean, double factor, double* scaled) {
  for (std::size_t i = 0; i < size; ++i) {
    scaled[i] = (heights[i] - mean) * factor;
  }
}

}  // namespace

AmplitudeMeasure amplitude_measure(std::string_view name) {
  if (name == "height") {
    return AmplitudeMeasure::height;
  }
  if (name == "Ra") {
    return AmplitudeMeasure::ra;
  }
  if (name == "Rq") {
    return AmplitudeMeasure::rq;
  }
  throw std::invalid_argument("measure must be height, Ra or Rq, got " + std::string(name));
}

HeightAccumulator::HeightAccumulator() {
  sums_.fill(0.0);
  minima_.fill(std::numeric_limits<double>::infinity());
  maxima_.fill(-std::numeric_limits<double>::infinity());
}

void HeightAccumulator::add(Values heights) {
  accumulate_heights(heights.data(), heights.size(), sums_.data(), minima_.data(), maxima_.data());
  count_ += heights.size();
}

HeightStatistics HeightAccumulator::statistics() const {
  return {std::accumulate(sums_.begin(), sums_.end(), 0.0) / static_cast<double>(count_),
          *std::min_element(minima_.begin(), minima_.end()), *std::max_element(maxima_.begin(), maxima_.end())};
}

std::optional<Scaling> find_scaling(double amplitude, AmplitudeMeasure measure, Values heights,
                                    const HeightStatistics& statistics) {
  const auto size = static_cast<double>(heights.size());
  const double mean = statistics.mean;
  double measured = statistics.max - statistics.min;
  if (measure == AmplitudeMeasure::ra) {
    measured = std::accumulate(heights.begin(), heights.end(), 0.0,
                               [&](double total, double height) { return total + std::abs(height - mean); }) /
               size;
  } else if (measure == AmplitudeMeasure::rq) {
    measured = std::sqrt(
        std::accumulate(heights.begin(), heights.end(), 0.0,
                        [&](double total, double height) { return total + (height - mean) * (height - mean); }) /
        size);
  }
  if (!(statistics.max > statistics.min) || !(measured > 0.0)) {
    return std::nullopt;
  }
  return Scaling{mean, amplitude / measured};
}

void scale(Values heights, const Scaling& scaling, std::span<double> scaled) {
  scale_heights(heights.data(), heights.size(), scaling.mean, scaling.factor, scaled.data());
}

bool scale_to_amplitude(Values heights, double amplitude, AmplitudeMeasure measure, std::span<double> scaled) {
  if (scaled.size() != heights.size() || heights.empty()) {
    throw std::invalid_argument("scale_to_amplitude: scaled must be as long as heights, and not empty");
  }
  HeightAccumulator accumulator;
  accumulator.add(heights);
  const std::optional<Scaling> scaling = find_scaling(amplitude, measure, heights, accumulator.statistics());
  if (scaling) {
    scale(heights, *scaling, scaled);
  }
  return scaling.has_value();
}

}  // namespace stiction
