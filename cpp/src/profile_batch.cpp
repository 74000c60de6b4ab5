#include "stiction/profile_batch.hpp"

#include "stiction/detection.hpp"

#include <algorithm>
#include <stdexcept>

namespace stiction {
namespace {

std::span<double> to_row(Eigen::Ref<Matrix>& heights, Index row) {
  return {heights.row(row).data(), static_cast<std::size_t>(heights.cols())};
}

Scaling find_scaling_or_throw(Values heights, const HeightStatistics& statistics, double amplitude,
                              AmplitudeMeasure measure) {
  const auto scaling = find_scaling(amplitude, measure, heights, statistics);
  if (!scaling) {
    throw std::invalid_argument("a flat profile cannot be scaled to an amplitude");
  }
  return *scaling;
}

// Scale two profiles chunk by chunk, and find the smallest gaps of each chunk while it is in the cache.
Prefilter scale_and_prefilter(Values upper, const Scaling& upper_scaling, Values lower, const Scaling& lower_scaling,
                              std::span<double> scaled_upper, std::span<double> scaled_lower) {
  constexpr std::size_t chunk = 4 * Prefilter::block;
  Prefilter prefilter;
  prefilter.block_min_gap.reserve(upper.size() / Prefilter::block + 1);
  for (std::size_t begin = 0; begin < upper.size(); begin += chunk) {
    const std::size_t count = std::min(chunk, upper.size() - begin);
    const auto upper_chunk = scaled_upper.subspan(begin, count);
    const auto lower_chunk = scaled_lower.subspan(begin, count);
    scale(upper.subspan(begin, count), upper_scaling, upper_chunk);
    scale(lower.subspan(begin, count), lower_scaling, lower_chunk);
    prefilter.add(upper_chunk, lower_chunk);
  }
  return prefilter;
}

}  // namespace

std::vector<Sums> press_profile_batches(ProfileBatch upper, ProfileBatch lower, double spacing,
                                        const Amplitudes& amplitudes, Values approaches,
                                        std::span<const ContactModel> models, Eigen::Ref<Matrix> scratch,
                                        const CancellationCheck& check_cancellation) {
  const Index rows = upper.heights.rows();
  const Index points = upper.heights.cols();
  if (lower.heights.rows() != rows || lower.heights.cols() != points) {
    throw std::invalid_argument("press_profile_batches: upper and lower must have equal numbers of rows and points");
  }
  if (upper.statistics.size() != static_cast<std::size_t>(rows) ||
      lower.statistics.size() != static_cast<std::size_t>(rows)) {
    throw std::invalid_argument("press_profile_batches: statistics must have one element for each row");
  }
  if (scratch.rows() != 2 || scratch.cols() != points) {
    throw std::invalid_argument("press_profile_batches: scratch must have two rows with as many points as upper");
  }
  std::vector<Sums> result;
  result.reserve(static_cast<std::size_t>(rows) * amplitudes.values.size() * models.size() * approaches.size());
  for (Index row = 0; row < rows; ++row) {
    const std::span<double> upper_row = to_row(upper.heights, row);
    const std::span<double> lower_row = to_row(lower.heights, row);
    const auto r = static_cast<std::size_t>(row);
    for (std::size_t a = 0; a < amplitudes.values.size(); ++a) {
      const double amplitude = amplitudes.values[a];
      const Scaling upper_scaling =
          find_scaling_or_throw(upper_row, upper.statistics[r], amplitude, amplitudes.measure);
      const Scaling lower_scaling =
          find_scaling_or_throw(lower_row, lower.statistics[r], amplitude, amplitudes.measure);
      const bool is_last = a + 1 == amplitudes.values.size();
      const std::span<double> scaled_upper = is_last ? upper_row : to_row(scratch, 0);
      const std::span<double> scaled_lower = is_last ? lower_row : to_row(scratch, 1);
      const Prefilter prefilter =
          scale_and_prefilter(upper_row, upper_scaling, lower_row, lower_scaling, scaled_upper, scaled_lower);
      for (const ContactModel& model : models) {
        const std::vector<Sums> sums =
            press({scaled_upper, scaled_lower, spacing}, prefilter, approaches, model, check_cancellation);
        result.insert(result.end(), sums.begin(), sums.end());
      }
    }
  }
  return result;
}

}  // namespace stiction
