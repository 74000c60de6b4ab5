#include "stiction/families.hpp"

#include "stiction/detection.hpp"

#include <algorithm>
#include <stdexcept>

namespace stiction {
namespace {

std::span<double> row_of(Eigen::Ref<Matrix>& heights, Index row) {
  return {heights.row(row).data(), static_cast<std::size_t>(heights.cols())};
}

Scaling scaling_of(Values heights, const Level& level, double amplitude, AmplitudeMeasure measure) {
  const auto scaling = scaling_to(amplitude, measure, heights, level);
  if (!scaling) {
    throw std::invalid_argument("a flat profile has no amplitude to scale");
  }
  return *scaling;
}

// Scales both and screens them, piece by piece, so that each piece is in the cache when it is looked at.
Screening scaled_pair(Values upper, const Scaling& of_upper, Values lower, const Scaling& of_lower,
                      std::span<double> scaled_upper, std::span<double> scaled_lower) {
  constexpr std::size_t piece = 4 * Screening::block;
  Screening screening;
  screening.block_gap.reserve(upper.size() / Screening::block + 1);
  for (std::size_t begin = 0; begin < upper.size(); begin += piece) {
    const std::size_t count = std::min(piece, upper.size() - begin);
    const auto upper_piece = scaled_upper.subspan(begin, count);
    const auto lower_piece = scaled_lower.subspan(begin, count);
    scale(upper.subspan(begin, count), of_upper, upper_piece);
    scale(lower.subspan(begin, count), of_lower, lower_piece);
    screening.add(upper_piece, lower_piece);
  }
  return screening;
}

}  // namespace

std::vector<Sums> press_families(Family upper, Family lower, double spacing, const Amplitudes& amplitudes,
                                 Values approaches, std::span<const ContactModel> models, Eigen::Ref<Matrix> scratch,
                                 const Checkpoint& checkpoint) {
  const Index rows = upper.heights.rows();
  const Index points = upper.heights.cols();
  if (lower.heights.rows() != rows || lower.heights.cols() != points) {
    throw std::invalid_argument("press_families: upper and lower must have equally many rows and points");
  }
  if (upper.levels.size() != static_cast<std::size_t>(rows) || lower.levels.size() != static_cast<std::size_t>(rows)) {
    throw std::invalid_argument("press_families: levels must be one for each row");
  }
  if (scratch.rows() != 2 || scratch.cols() != points) {
    throw std::invalid_argument("press_families: scratch must be two rows of as many points");
  }
  std::vector<Sums> all;
  all.reserve(static_cast<std::size_t>(rows) * amplitudes.values.size() * models.size() * approaches.size());
  for (Index row = 0; row < rows; ++row) {
    const std::span<double> upper_row = row_of(upper.heights, row);
    const std::span<double> lower_row = row_of(lower.heights, row);
    const auto r = static_cast<std::size_t>(row);
    for (std::size_t a = 0; a < amplitudes.values.size(); ++a) {
      const double amplitude = amplitudes.values[a];
      const Scaling of_upper = scaling_of(upper_row, upper.levels[r], amplitude, amplitudes.measure);
      const Scaling of_lower = scaling_of(lower_row, lower.levels[r], amplitude, amplitudes.measure);
      const bool is_last = a + 1 == amplitudes.values.size();
      const std::span<double> scaled_upper = is_last ? upper_row : row_of(scratch, 0);
      const std::span<double> scaled_lower = is_last ? lower_row : row_of(scratch, 1);
      const Screening screening = scaled_pair(upper_row, of_upper, lower_row, of_lower, scaled_upper, scaled_lower);
      for (const ContactModel& model : models) {
        const std::vector<Sums> sums =
            press({scaled_upper, scaled_lower, spacing}, screening, approaches, model, checkpoint);
        all.insert(all.end(), sums.begin(), sums.end());
      }
    }
  }
  return all;
}

}  // namespace stiction
