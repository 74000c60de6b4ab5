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

// One root, from the bracket of its ends: `one` is the last estimate, `two` lies on the other side of the root, `three`
// is the one before.
struct Search {
  Point one;
  Point two;
  Point three;
  double share;  // of the bracket at which the next estimate lies
  bool done;

  double next() const { return one.x + share * (two.x - one.x); }

  const Point& best() const { return std::abs(one.f) < std::abs(two.f) ? one : two; }

  void take(double f, double tolerance) {
    const Point estimate{next(), f};
    three = two;
    if (sign(f) == sign(one.f)) {
      three = one;
    } else {
      two = one;
    }
    one = estimate;
    finish(tolerance);
    if (!done) {
      choose(tolerance);
    }
  }

  void finish(double tolerance) {
    done = best().f == 0.0 || sign(one.f) == sign(two.f) || !(width() >= std::abs(best().x) * tolerance);
  }

  double width() const { return std::abs(two.x - one.x); }

  void choose(double tolerance) {
    const double xi = (one.x - two.x) / (three.x - two.x);
    const double phi = (one.f - two.f) / (three.f - two.f);
    const double alpha = (three.x - one.x) / (two.x - one.x);
    share = 0.5;
    if (1.0 - std::sqrt(1.0 - xi) < phi && phi < std::sqrt(xi)) {
      share = one.f / (one.f - two.f) * three.f / (three.f - two.f) -
              alpha * one.f / (three.f - one.f) * two.f / (two.f - three.f);
    }
    const double least = 0.5 * (std::abs(best().x) * tolerance) / width();
    share = std::min(std::max(share, least), 1.0 - least);
  }

  double root() const {
    if (best().f >= 0.0) {
      return best().x;
    }
    const Point& behind = one.x < two.x ? two : one;
    const Point& before = one.x < two.x ? one : two;
    return behind.f >= 0.0 ? behind.x : before.x;
  }
};

template <class Bodies>
std::vector<double> approaches_of(const Bodies& bodies, Values loads, Values left, Values right, double mu0,
                                  double tau0, const ContactModel& model, const Checkpoint& checkpoint) {
  constexpr double tolerance = 1e-12;
  const auto normal_loads = [&](Values approaches) {
    std::vector<double> loads_there;
    for (const Sums& sums : press(bodies, approaches, model, checkpoint)) {
      loads_there.push_back(normal_load(sums, mu0, tau0));
    }
    return loads_there;
  };
  return rises_through(normal_loads, loads, left, right, tolerance);
}

}  // namespace

std::vector<double> rises_through(const ManyValues& function, Values levels, Values left, Values right,
                                  double tolerance) {
  if (left.size() != levels.size() || right.size() != levels.size()) {
    throw std::invalid_argument("left and right must be as many as levels");
  }
  // Values at some arguments, given in any order and more than once.
  const auto values_at = [&](const std::vector<double>& arguments) {
    std::vector<double> distinct = arguments;
    std::sort(distinct.begin(), distinct.end());
    distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
    const std::vector<double> at_distinct = function(distinct);
    std::vector<double> values;
    for (const double argument : arguments) {
      const auto place = std::lower_bound(distinct.begin(), distinct.end(), argument) - distinct.begin();
      values.push_back(at_distinct[static_cast<std::size_t>(place)]);
    }
    return values;
  };
  if (levels.empty()) {
    return {};
  }
  const std::vector<double> at_left = values_at({left.begin(), left.end()});
  const std::vector<double> at_right = values_at({right.begin(), right.end()});
  std::vector<Search> searches;
  for (std::size_t l = 0; l < levels.size(); ++l) {
    const Point first{left[l], at_left[l] - levels[l]};
    const Point last{right[l], at_right[l] - levels[l]};
    searches.push_back({first, last, last, 0.5, false});
    searches.back().finish(tolerance);
  }
  constexpr int most_steps = 2000;  // a bisection of all doubles takes fewer
  for (int step = 0; step < most_steps; ++step) {
    std::vector<double> arguments;
    for (const Search& search : searches) {
      if (!search.done) {
        arguments.push_back(search.next());
      }
    }
    if (arguments.empty()) {
      break;
    }
    const std::vector<double> values = values_at(arguments);
    auto value = values.begin();
    for (std::size_t l = 0; l < levels.size(); ++l) {
      if (!searches[l].done) {
        searches[l].take(*value++ - levels[l], tolerance);
      }
    }
  }
  std::vector<double> roots;
  roots.reserve(searches.size());
  roots.reserve(searches.size());
  for (const Search& search : searches) {
    roots.push_back(search.root());
  }
  return roots;
}

std::vector<double> approaches_at(const ProfilePair& pair, Values loads, Values left, Values right, double mu0,
                                  double tau0, const ContactModel& model, const Checkpoint& checkpoint) {
  return approaches_of(pair, loads, left, right, mu0, tau0, model, checkpoint);
}

std::vector<double> approaches_at(const Candidates& found, Values loads, Values left, Values right, double mu0,
                                  double tau0, const ContactModel& model, const Checkpoint& checkpoint) {
  return approaches_of(found, loads, left, right, mu0, tau0, model, checkpoint);
}

std::vector<double> approaches_at(const ArealCandidates& found, Values loads, Values left, Values right, double mu0,
                                  double tau0, const ContactModel& model, const Checkpoint& checkpoint) {
  return approaches_of(found, loads, left, right, mu0, tau0, model, checkpoint);
}

}  // namespace stiction
