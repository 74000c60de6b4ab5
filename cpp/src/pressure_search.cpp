#include "stiction/pressure_search.hpp"

#include "multiversion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace stiction {
namespace {

// Steps whose best length differs more than this from the one tried are cut or the next one is lengthened by it.
constexpr double least_change = 0.5;
constexpr double most_change = 2.0;
constexpr double most_regain = 100.0;  // after steps that lead nowhere
// Of preconditioned steps one after the other that lead nowhere: twice as many plain ones follow each time.
constexpr int most_failures = 6;
// After a step that leads nowhere.
constexpr double retreat = 0.25;
// Of a free point's target over the load of all, beyond which round-off would be a part of that load. Steps that meet
// bounds are always too short, so that their length would grow for ever.
constexpr double most_reach = 1e3;
constexpr int most_newton_steps = 200;
constexpr std::size_t sums_at_once = 8;
// Points of a grid, and free ones among them, that one thread looks at.
constexpr std::size_t points_at_once = std::size_t{1} << 16;
constexpr std::size_t free_at_once = std::size_t{1} << 16;

// Adds what the last step did to some potentials.
STICTION_MULTIVERSION
void add_scaled(const float* response, std::size_t size, double factor, double* potential) {
  for (std::size_t i = 0; i < size; ++i) {
    potential[i] += factor * static_cast<double>(response[i]);
  }
}

// Marks free points of a few: between 0 and their bound, or at one that the gap calls them away from (or is not a
// number). Returns whether there are any.
STICTION_MULTIVERSION
bool mark_free(const double* pressure, const double* potential, const double* bound, std::size_t size, double approach,
               std::uint8_t* marks) {
  std::uint8_t any = 0;
  for (std::size_t i = 0; i < size; ++i) {
    const double p = pressure[i];
    const double gap = potential[i] - approach;
    const bool loaded = p > 0.0;
    // Without branches, which are hard to foresee.
    const bool is_free = (loaded & ((p < bound[i]) | (gap > 0.0))) | (!loaded & (bound[i] > 0.0) & !(gap >= 0.0));
    marks[i] = static_cast<std::uint8_t>(is_free);
    any |= marks[i];
  }
  return any != 0;
}

// from + slope, from + 2 slope, ... beginning at a multiple.
STICTION_MULTIVERSION
void draw_line(float from, float slope, std::int32_t first, std::int32_t count, float* values) {
  for (std::int32_t j = 0; j < count; ++j) {
    values[j] = from + slope * static_cast<float>(first + j);
  }
}

struct Moments {
  double sum = 0.0;
  double moment = 0.0;  // of first, first + 1, ... times the values
};

STICTION_MULTIVERSION
Moments moments_of(const float* values, std::int32_t first, std::int32_t count) {
  std::array<double, sums_at_once> sums{};
  std::array<double, sums_at_once> moments{};
  constexpr auto lanes = static_cast<std::int32_t>(sums_at_once);
  const std::int32_t whole = count - count % lanes;
  for (std::int32_t j = 0; j < whole; j += lanes) {
    for (std::int32_t lane = 0; lane < lanes; ++lane) {
      const auto value = static_cast<double>(values[j + lane]);
      sums[static_cast<std::size_t>(lane)] += value;
      moments[static_cast<std::size_t>(lane)] += value * static_cast<double>(first + j + lane);
    }
  }
  for (std::int32_t j = whole; j < count; ++j) {
    const auto value = static_cast<double>(values[j]);
    sums[0] += value;
    moments[0] += value * static_cast<double>(first + j);
  }
  return {std::accumulate(sums.begin(), sums.end(), 0.0), std::accumulate(moments.begin(), moments.end(), 0.0)};
}

struct Loads {
  double between = 0.0;   // of points below their bound
  double at_bound = 0.0;  // of points at it
};

// Sums of a few pressures; in as many sums as make it fast, as below.
STICTION_MULTIVERSION
Loads loads_of(const double* pressure, const double* bound, std::size_t size) {
  std::array<double, sums_at_once> between{};
  std::array<double, sums_at_once> at_bound{};
  for (std::size_t i = 0; i < size; ++i) {
    const bool below = pressure[i] < bound[i];
    between[i % sums_at_once] += below ? pressure[i] : 0.0;
    at_bound[i % sums_at_once] += below ? 0.0 : pressure[i];
  }
  return {std::accumulate(between.begin(), between.end(), 0.0), std::accumulate(at_bound.begin(), at_bound.end(), 0.0)};
}

STICTION_MULTIVERSION
void scale_between(double* pressure, const double* bound, std::size_t size, double factor) {
  for (std::size_t i = 0; i < size; ++i) {
    const double scaled = pressure[i] * factor;
    pressure[i] = pressure[i] < bound[i] ? (scaled < bound[i] ? scaled : bound[i]) : pressure[i];
  }
}

struct Cut {
  double sum = 0.0;
  double between = 0.0;  // how many are within the bounds

  void add(const Cut& other) {
    sum += other.sum;
    between += other.between;
  }
};

// Pressures less the shift, cut to 0 and their bounds.
STICTION_MULTIVERSION
Cut cut(const double* pressure, const double* bound, std::size_t size, double shift) {
  std::array<double, sums_at_once> sums{};
  std::array<double, sums_at_once> between{};
  std::size_t i = 0;
  for (; i + sums_at_once <= size; i += sums_at_once) {
    for (std::size_t lane = 0; lane < sums_at_once; ++lane) {
      const double moved = pressure[i + lane] - shift;
      const double kept = moved > 0.0 ? moved : 0.0;
      sums[lane] += kept < bound[i + lane] ? kept : bound[i + lane];
      between[lane] += moved > 0.0 && moved < bound[i + lane] ? 1.0 : 0.0;
    }
  }
  for (; i < size; ++i) {
    const double moved = pressure[i] - shift;
    sums[0] += std::clamp(moved, 0.0, bound[i]);
    between[0] += moved > 0.0 && moved < bound[i] ? 1.0 : 0.0;
  }
  return {std::accumulate(sums.begin(), sums.end(), 0.0), std::accumulate(between.begin(), between.end(), 0.0)};
}

std::size_t point(const std::vector<std::int32_t>& points, std::size_t k) {
  return static_cast<std::size_t>(points[k]);
}

// What `work(first, last)` gives for each part, put together in their order.
template <class Sums, class Work>
Sums sums_in_parts(std::size_t count, const Crew& crew, const Work& work) {
  std::vector<Sums> parts(std::max<std::size_t>((count + free_at_once - 1) / free_at_once, 1));
  crew.in_parts(count, free_at_once,
                [&](std::size_t first, std::size_t last) { parts[first / free_at_once] = work(first, last); });
  Sums all = parts[0];
  for (std::size_t part = 1; part < parts.size(); ++part) {
    all.add(parts[part]);
  }
  return all;
}

// The shift for which pressures less the shift, cut to the bounds, have the sum asked for. The sum falls with the
// shift, in straight pieces: Newton's steps, kept within a bracket.
double shift_to_sum(std::span<const double> pressure, std::span<const double> bound, double sum, const Crew& crew) {
  double left = -std::numeric_limits<double>::infinity();
  double right = std::numeric_limits<double>::infinity();
  double shift = 0.0;
  for (int count = 0; count < most_newton_steps; ++count) {
    const Cut now = sums_in_parts<Cut>(pressure.size(), crew, [&](std::size_t first, std::size_t last) {
      return cut(&pressure[first], &bound[first], last - first, shift);
    });
    const double excess = now.sum - sum;
    if (std::abs(excess) <= 1e-15 * sum) {
      return shift;
    }
    (excess > 0.0 ? left : right) = shift;
    double next = now.between > 0.0 ? shift + excess / now.between : left + 0.5 * (right - left);
    if (!std::isfinite(next)) {  // no pressure between the bounds, and only one side known
      const auto [lowest, highest] = std::minmax_element(pressure.begin(), pressure.end());
      const double most = *std::max_element(bound.begin(), bound.end());
      left = std::isfinite(left) ? left : *lowest - (std::isfinite(most) ? most : sum);
      right = std::isfinite(right) ? right : *highest;
      next = left + 0.5 * (right - left);
    } else if (!(next > left && next < right)) {
      next = left + 0.5 * (right - left);
    }
    if (next == shift) {
      return shift;
    }
    shift = next;
  }
  return shift;
}

}  // namespace

PressureSearch::PressureSearch(std::vector<double> pressure, double total, Values bound, bool line)
    : pressure_(std::move(pressure)), total_(total), line_(line), residual_(pressure_.size()), step_(pressure_.size()) {
  const std::size_t size = pressure_.size();
  if (size == 0 || size > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max())) {
    throw std::invalid_argument("PressureSearch: pressure must have from 1 to below 2^31 points");
  }
  if ((bound.size() != 1 && bound.size() != size) ||
      !std::all_of(bound.begin(), bound.end(), [](double one) { return one >= 0.0; })) {
    throw std::invalid_argument("PressureSearch: bound must be one for all points or one for each, none below 0");
  }
  if (bound.size() == size) {
    bounds_.assign(bound.begin(), bound.end());
  }
  everywhere_.fill(bound[0]);
  const double most = bounds_.empty() ? everywhere_[0] * static_cast<double>(size)
                                      : std::accumulate(bounds_.begin(), bounds_.end(), 0.0);
  if (!(total > 0.0) || !(total < most)) {
    throw std::invalid_argument("PressureSearch: total must be positive and below the sum of the bounds");
  }
  // As many points bear the load as are needed.
  const auto bear = [&](std::size_t i) {
    moved_.push_back(static_cast<std::int32_t>(i));
    target_.push_back(pressure_[i]);
    most_.push_back(bound_at(i));
  };
  for (std::size_t i = 0; i < size; ++i) {
    if (pressure_[i] > 0.0) {
      bear(i);
    }
  }
  if (!(std::accumulate(most_.begin(), most_.end(), 0.0) > total)) {
    moved_.clear();
    target_.clear();
    most_.clear();
    for (std::size_t i = 0; i < size; ++i) {
      bear(i);
    }
  }
  const double shift = shift_to_sum(target_, most_, total, Crew());
  for (std::size_t k = 0; k < moved_.size(); ++k) {
    pressure_[static_cast<std::size_t>(moved_[k])] = std::clamp(target_[k] - shift, 0.0, most_[k]);
  }
  settle();
}

void PressureSearch::settle() {
  const std::size_t size = pressure_.size();
  const auto bounds = [&](std::size_t first) { return bounds_.empty() ? everywhere_.data() : &bounds_[first]; };
  Loads all;
  for (std::size_t first = 0; first < size; first += block) {
    const Loads few = loads_of(&pressure_[first], bounds(first), std::min(block, size - first));
    all.between += few.between;
    all.at_bound += few.at_bound;
  }
  const double factor = (total_ - all.at_bound) / all.between;
  if (all.between > 0.0 && factor > 0.0) {
    for (std::size_t first = 0; first < size; first += block) {
      scale_between(&pressure_[first], bounds(first), std::min(block, size - first), factor);
    }
  }
}

void PressureSearch::check(std::span<const float> grid) const {
  if (grid.size() != pressure_.size()) {
    throw std::invalid_argument("PressureSearch: grids must have as many points as the pressure");
  }
}

double PressureSearch::balance(const Crew& crew) {
  if (potential_.size() != pressure_.size()) {
    throw std::logic_error("PressureSearch: a potential comes before a balance");
  }
  if (line_) {
    std::fill(residual_.begin(), residual_.end(), 0.0F);
  } else {
    crew.in_parts(free_.size(), free_at_once, [&](std::size_t first, std::size_t last) {
      for (std::size_t k = first; k < last; ++k) {
        residual_[point(free_, k)] = 0.0F;
      }
    });
  }
  // Every point under pressure has moved, or is at its bound and says nothing of the approach.
  const float* response = part_ != 0.0 ? response_.data() : residual_.data();
  const Cut between = sums_in_parts<Cut>(moved_.size(), crew, [&](std::size_t first, std::size_t last) {
    Cut some;
    for (std::size_t k = first; k < last; ++k) {
      const std::size_t i = point(moved_, k);
      const double p = pressure_[i];
      const bool is_between = (p > 0.0) & (p < bound_at(i));  // without a branch, which is hard to foresee
      some.sum += is_between ? potential_[i] + part_ * static_cast<double>(response[i]) : 0.0;
      some.between += is_between ? 1.0 : 0.0;
    }
    return some;
  });
  if (between.between == 0.0) {
    add_response(0, pressure_.size());
    part_ = 0.0;
  }
  approach_ = between.between > 0.0 ? between.sum / between.between : approach_of_bounds();
  // The last step, and at once who is free now: the grid is read but once.
  const std::size_t size = pressure_.size();
  found_.resize((size + points_at_once - 1) / points_at_once);
  crew.each(found_.size(), [&](std::size_t part, std::size_t) {
    found_[part].clear();
    mark(part * points_at_once, std::min((part + 1) * points_at_once, size), found_[part]);
  });
  part_ = 0.0;
  free_.clear();
  for (const std::vector<std::int32_t>& found : found_) {
    free_.insert(free_.end(), found.begin(), found.end());
  }
  struct Gaps {
    double farthest = 0.0;
    double sum = 0.0;

    void add(const Gaps& other) {
      farthest = std::max(farthest, other.farthest);
      sum += other.sum;
    }
  };
  const Gaps gaps = sums_in_parts<Gaps>(free_.size(), crew, [&](std::size_t first, std::size_t last) {
    Gaps some;
    for (std::size_t k = first; k < last; ++k) {
      const double gap = potential_[point(free_, k)] - approach_;
      some.farthest = std::max(some.farthest, std::abs(gap));
      some.sum += gap;
    }
    return some;
  });
  mean_ = approach_ + (free_.empty() ? 0.0 : gaps.sum / static_cast<double>(free_.size()));
  return std::isfinite(mean_) ? gaps.farthest : std::numeric_limits<double>::infinity();
}

void PressureSearch::add_response(std::size_t first, std::size_t count) {
  if (part_ != 0.0) {
    add_scaled(&response_[first], count, part_, &potential_[first]);
  }
}

void PressureSearch::mark(std::size_t first, std::size_t last, std::vector<std::int32_t>& found) {
  std::array<std::int32_t, block> places{};
  std::array<std::uint8_t, block> marks{};
  for (; first < last; first += block) {
    const std::size_t count = std::min(block, last - first);
    const double* bound = bounds_.empty() ? everywhere_.data() : &bounds_[first];
    add_response(first, count);
    if (mark_free(&pressure_[first], &potential_[first], bound, count, approach_, marks.data())) {
      std::size_t many = 0;
      for (std::size_t from = 0; from < count; from += sums_at_once) {
        std::uint64_t some = 0;
        std::memcpy(&some, &marks[from], sizeof(some));
        if (some == 0) {
          continue;
        }
        for (std::size_t i = from; i < std::min(from + sums_at_once, count); ++i) {
          places[many] = static_cast<std::int32_t>(first + i);
          many += marks[i];
        }
      }
      found.insert(found.end(), places.begin(), places.begin() + static_cast<std::ptrdiff_t>(many));
    }
  }
}

// Where no pressure lies between the bounds: points at theirs may not be open, and those without pressure not overlap.
// The last of the first where that can be, else midway, so that there are points on both sides to take and to give.
double PressureSearch::approach_of_bounds() const {
  double last = -std::numeric_limits<double>::infinity();
  double first = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < pressure_.size(); ++i) {
    if (pressure_[i] > 0.0) {
      last = std::max(last, potential_[i]);
    } else if (bound_at(i) > 0.0) {
      first = std::min(first, potential_[i]);
    }
  }
  return last <= first ? last : first + 0.5 * (last - first);
}

// Each run of points that are not free: the free points on both sides (by their place in the list) and how many there
// are, then its parts on this side of the edge and beyond: the first point, how many, and how many of the run precede.
template <class Between>
void PressureSearch::for_each_gap(Between between) const {
  const auto size = static_cast<std::int32_t>(pressure_.size());
  const std::size_t last = free_.size() - 1;
  for (std::size_t k = 0; k < last; ++k) {
    const std::int32_t count = free_[k + 1] - free_[k] - 1;
    if (count > 0) {
      between(k, k + 1, count, std::array<Run, 2>{{{free_[k] + 1, count, 0}, {0, 0, count}}});
    }
  }
  const std::int32_t after = size - free_[last] - 1;
  between(last, std::size_t{0}, after + free_[0],
          std::array<Run, 2>{{{free_[last] + 1, after, 0}, {0, free_[0], after}}});
}

std::span<const float> PressureSearch::residual(const Crew& crew) {
  crew.in_parts(free_.size(), free_at_once, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) {
      const std::size_t i = point(free_, k);
      residual_[i] = static_cast<float>(mean_ - potential_[i]);
    }
  });
  if (continued()) {
    for_each_gap([&](std::size_t left, std::size_t right, std::int32_t count, const std::array<Run, 2>& runs) {
      const float from = residual_[static_cast<std::size_t>(free_[left])];
      const float slope = (residual_[static_cast<std::size_t>(free_[right])] - from) / static_cast<float>(count + 1);
      for (const Run& run : runs) {
        draw_line(from, slope, run.before + 1, run.count, residual_.data() + run.first);
      }
    });
  }
  return residual_;
}

void PressureSearch::collect(std::span<const float> preconditioned) {
  collected_.resize(free_.size());
  for (std::size_t k = 0; k < free_.size(); ++k) {
    collected_[k] = static_cast<double>(preconditioned[static_cast<std::size_t>(free_[k])]);
  }
  if (continued()) {
    for_each_gap([&](std::size_t left, std::size_t right, std::int32_t count, const std::array<Run, 2>& runs) {
      Moments total;
      for (const Run& run : runs) {
        const Moments one = moments_of(preconditioned.data() + run.first, run.before + 1, run.count);
        total.sum += one.sum;
        total.moment += one.moment;
      }
      total.moment /= static_cast<double>(count + 1);
      collected_[left] += total.sum - total.moment;
      collected_[right] += total.moment;
    });
  }
}

std::span<const float> PressureSearch::step(std::span<const float> preconditioned, std::span<const float> response,
                                            const Crew& crew) {
  check(preconditioned);
  if (!response.empty()) {
    check(response);
  }
  const std::size_t size = free_.size();
  const auto count = static_cast<double>(std::max<std::size_t>(size, 1));
  collect(preconditioned);
  conjugate_ = conjugate_ && !response.empty();
  struct Products {
    double load = 0.0;  // of free points, which a step keeps: what it lacked would grow with longer steps
    double value = 0.0;
    double step = 0.0;
    double response = 0.0;
    double product = 0.0;

    void add(const Products& other) {
      load += other.load;
      value += other.value;
      step += other.step;
      response += other.response;
      product += other.product;
    }
  };
  target_.resize(size);
  most_.resize(size);
  const Products sums = sums_in_parts<Products>(size, crew, [&](std::size_t first, std::size_t last) {
    Products some;
    for (std::size_t k = first; k < last; ++k) {
      const std::size_t i = point(free_, k);
      const double value = collected_[k];
      most_[k] = bound_at(i);
      some.load += pressure_[i];
      some.value += value;
      if (conjugate_) {
        some.step += static_cast<double>(step_[i]);
        some.response += static_cast<double>(response[i]);
        some.product += value * static_cast<double>(response[i]);
      }
    }
    return some;
  });
  const double mean = sums.value / count;
  const double mean_step = sums.step / count;
  double beta = conjugate_ ? std::max((mean * sums.response - sums.product) / curvature_, 0.0) : 0.0;
  length_before_ = plain_length_;
  struct Aim {
    double slope = 0.0;
    double square = 0.0;
    double reach = 0.0;
    bool outside = false;

    void add(const Aim& other) {
      slope += other.slope;
      square += other.square;
      reach = std::max(reach, other.reach);
      outside |= other.outside;
    }
  };
  const auto aim = [&] {
    const double length = plain_ ? plain_length_ : length_;
    const Aim all = sums_in_parts<Aim>(size, crew, [&](std::size_t first, std::size_t last) {
      Aim some;
      for (std::size_t k = first; k < last; ++k) {
        const std::size_t i = point(free_, k);
        const auto rest = static_cast<double>(residual_[i]);
        double direction = collected_[k] - mean;
        if (beta > 0.0) {
          direction += beta * (static_cast<double>(step_[i]) - mean_step);
        }
        some.slope += direction * rest;
        some.square += rest * rest;
        some.reach = std::max(some.reach, std::abs(length * direction));
        target_[k] = pressure_[i] + length * direction;
        some.outside |= (target_[k] < 0.0) | (target_[k] > most_[k]);
      }
      return some;
    });
    clipped_ = all.outside;
    if (!plain_ && all.slope > 0.0 && all.square > 0.0) {
      plain_length_ = length_ * all.slope / all.square;
    }
    return all;
  };
  Aim aimed = aim();
  if (!(aimed.slope > 0.0) && beta > 0.0) {
    beta = 0.0;
    aimed = aim();
  }
  if (sums.load > 0.0 && aimed.reach > most_reach * sums.load) {
    (plain_ ? plain_length_ : length_) *= most_reach * sums.load / aimed.reach;
    aim();
  }
  conjugate_ = beta > 0.0;
  const double shift = shift_to_sum(target_, most_, sums.load, crew);
  crew.in_parts(moved_.size(), free_at_once, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) {
      step_[point(moved_, k)] = 0.0F;
    }
  });
  moved_ = free_;
  crew.in_parts(size, free_at_once, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) {
      const std::size_t i = point(free_, k);
      target_[k] = std::clamp(target_[k] - shift, 0.0, most_[k]);
      step_[i] = static_cast<float>(target_[k] - pressure_[i]);
    }
  });
  return step_;
}

// The longest part of the step that keeps within the bounds.
double PressureSearch::farthest() const {
  double part = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < moved_.size(); ++k) {
    const std::size_t i = point(moved_, k);
    const auto move = static_cast<double>(step_[i]);
    const double room = move < 0.0 ? pressure_[i] : most_[k] - pressure_[i];
    part = move == 0.0 ? part : std::min(part, room / std::abs(move));
  }
  return part;
}

bool PressureSearch::advance(std::span<const float> response, const Crew& crew) {
  check(response);
  struct Energy {
    double descent = 0.0;
    double curvature = 0.0;

    void add(const Energy& other) {
      descent += other.descent;
      curvature += other.curvature;
    }
  };
  const Energy energy = sums_in_parts<Energy>(moved_.size(), crew, [&](std::size_t first, std::size_t last) {
    Energy some;
    for (std::size_t k = first; k < last; ++k) {
      const std::size_t i = point(moved_, k);
      const auto move = static_cast<double>(step_[i]);
      some.descent += move * (mean_ - potential_[i]);
      some.curvature += move * static_cast<double>(response[i]);
    }
    return some;
  });
  const double best = energy.descent / energy.curvature;
  if (!(energy.descent > 0.0) || !(energy.curvature > 0.0) || !std::isfinite(best)) {
    (plain_ ? plain_length_ : length_) *= retreat;
    if (!conjugate_ && !plain_) {
      plain_ = true;
      plain_length_ = length_before_;
      failures_ = std::min(failures_ + 1, most_failures);
      plain_steps_ = 1 << failures_;
    }
    conjugate_ = false;
    return false;
  }
  // A whole step that meets bounds is taken as it is where it lowers the energy: a part of it would leave a part of
  // the pressure on points that it wants to free.
  const double part =
      clipped_ ? (best >= least_change ? 1.0 : best) : (best <= 1.0 ? best : std::min(best, std::max(farthest(), 1.0)));
  crew.in_parts(moved_.size(), free_at_once, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) {
      const std::size_t i = point(moved_, k);
      pressure_[i] =
          part == 1.0 ? target_[k] : std::clamp(pressure_[i] + part * static_cast<double>(step_[i]), 0.0, most_[k]);
    }
  });
  response_ = response;
  part_ = part;
  if (plain_) {
    plain_length_ *= std::clamp(best, least_change, most_regain);
    plain_ = --plain_steps_ > 0;
  } else {
    length_ *= std::clamp(best, least_change, failures_ > 0 ? most_regain : most_change);
    failures_ = conjugate_ ? failures_ : 0;
  }
  curvature_ = energy.curvature;
  conjugate_ = true;
  return true;
}

double PressureSearch::work() const {
  return std::inner_product(pressure_.begin(), pressure_.end(), potential_.begin(), 0.0);
}

void PressureSearch::restart(std::vector<double> potential) {
  if (potential.size() != pressure_.size()) {
    throw std::invalid_argument("PressureSearch: potential must have as many points as the pressure");
  }
  potential_ = std::move(potential);
  part_ = 0.0;
  conjugate_ = false;
}

}  // namespace stiction
