#include "stiction/loading.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace stiction {
namespace {

double sign(double value) { return value > 0.0 ? 1.0 : value < 0.0 ? -1.0 : 0.0; }

struct Point {
  double x;
  double f;
};

// The root lies between the points `latest` and `opposite`. `previous` is the end of the bracket replaced by `latest`.
struct RootSearch {
  Point latest;
  Point opposite;
  Point previous;
  double fraction;  // position of the next estimate, as a fraction of the bracket
  bool done;

  double next() const { return latest.x + fraction * (opposite.x - latest.x); }

  const Point& best() const { return std::abs(latest.f) < std::abs(opposite.f) ? latest : opposite; }

  void add_estimate(double f, double tolerance) {
    const Point estimate{next(), f};
    previous = opposite;
    if (sign(f) == sign(latest.f)) {
      previous = latest;
    } else {
      opposite = latest;
    }
    latest = estimate;
    check_convergence(tolerance);
    if (!done) {
      choose_fraction(tolerance);
    }
  }

  void check_convergence(double tolerance) {
    done = best().f == 0.0 || sign(latest.f) == sign(opposite.f) || !(width() >= std::abs(best().x) * tolerance);
  }

  double width() const { return std::abs(opposite.x - latest.x); }

  void choose_fraction(double tolerance) {
    const double xi = (latest.x - opposite.x) / (previous.x - opposite.x);
    const double phi = (latest.f - opposite.f) / (previous.f - opposite.f);
    const double alpha = (previous.x - latest.x) / (opposite.x - latest.x);
    fraction = 0.5;
    if (1.0 - std::sqrt(1.0 - xi) < phi && phi < std::sqrt(xi)) {
      fraction = latest.f / (latest.f - opposite.f) * previous.f / (previous.f - opposite.f) -
                 alpha * latest.f / (previous.f - latest.f) * opposite.f / (opposite.f - previous.f);
    }
    const double margin = 0.5 * (std::abs(best().x) * tolerance) / width();
    fraction = std::min(std::max(fraction, margin), 1.0 - margin);
  }

  double root() const {
    if (best().f >= 0.0) {
      return best().x;
    }
    const Point& upper_end = latest.x < opposite.x ? opposite : latest;
    const Point& lower_end = latest.x < opposite.x ? latest : opposite;
    return upper_end.f >= 0.0 ? upper_end.x : lower_end.x;
  }
};

template <class Surfaces>
std::vector<double> find_approaches(const Surfaces& surfaces, Values loads, Values left, Values right, double mu0,
                                    double tau0, const ContactModel& model,
                                    const CancellationCheck& check_cancellation) {
  constexpr double tolerance = 1e-12;
  const auto normal_loads = [&](Values approaches) {
    std::vector<double> result;
    for (const Sums& sums : press(surfaces, approaches, model, check_cancellation)) {
      result.push_back(normal_load(sums, mu0, tau0));
    }
    return result;
  };
  return find_crossings(normal_loads, loads, left, right, tolerance);
}

}  // namespace

std::vector<double> find_crossings(const BatchFunction& function, Values levels, Values left, Values right,
                                   double tolerance) {
  if (left.size() != levels.size() || right.size() != levels.size()) {
    throw std::invalid_argument("find_crossings: left and right must be as long as levels");
  }
  // `arguments` may be in any order, and may contain duplicates.
  const auto values_at = [&](const std::vector<double>& arguments) {
    std::vector<double> distinct = arguments;
    std::sort(distinct.begin(), distinct.end());
    distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
    const std::vector<double> distinct_values = function(distinct);
    std::vector<double> values;
    for (const double argument : arguments) {
      const auto index = std::lower_bound(distinct.begin(), distinct.end(), argument) - distinct.begin();
      values.push_back(distinct_values[static_cast<std::size_t>(index)]);
    }
    return values;
  };
  if (levels.empty()) {
    return {};
  }
  const std::vector<double> left_values = values_at({left.begin(), left.end()});
  const std::vector<double> right_values = values_at({right.begin(), right.end()});
  std::vector<RootSearch> searches;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const Point first{left[i], left_values[i] - levels[i]};
    const Point last{right[i], right_values[i] - levels[i]};
    searches.push_back({first, last, last, 0.5, false});
    searches.back().check_convergence(tolerance);
  }
  constexpr int max_steps = 2000;  // bisecting the range of all doubles would take fewer steps
  for (int step = 0; step < max_steps; ++step) {
    std::vector<double> arguments;
    for (const RootSearch& search : searches) {
      if (!search.done) {
        arguments.push_back(search.next());
      }
    }
    if (arguments.empty()) {
      break;
    }
    const std::vector<double> values = values_at(arguments);
    auto value = values.begin();
    for (std::size_t i = 0; i < levels.size(); ++i) {
      if (!searches[i].done) {
        searches[i].add_estimate(*value++ - levels[i], tolerance);
      }
    }
  }
  std::vector<double> roots;
  roots.reserve(searches.size());
  for (const RootSearch& search : searches) {
    roots.push_back(search.root());
  }
  return roots;
}

std::vector<double> approaches_at(const ProfilePair& pair, Values loads, Values left, Values right, double mu0,
                                  double tau0, const ContactModel& model, const CancellationCheck& check_cancellation) {
  return find_approaches(pair, loads, left, right, mu0, tau0, model, check_cancellation);
}

std::vector<double> approaches_at(const Candidates& candidates, Values loads, Values left, Values right, double mu0,
                                  double tau0, const ContactModel& model, const CancellationCheck& check_cancellation) {
  return find_approaches(candidates, loads, left, right, mu0, tau0, model, check_cancellation);
}

std::vector<double> approaches_at(const ArealCandidates& candidates, Values loads, Values left, Values right,
                                  double mu0, double tau0, const ContactModel& model,
                                  const CancellationCheck& check_cancellation) {
  return find_approaches(candidates, loads, left, right, mu0, tau0, model, check_cancellation);
}

}  // namespace stiction
