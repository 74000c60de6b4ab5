#include "stiction/student.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <utility>

using stiction::student_probability;
using stiction::student_quantile;

namespace {

constexpr double round_off = 1e-14;

}  // namespace

TEST_CASE("Student's distribution of one and two degrees of freedom is that of closed forms") {
  for (const double probability : {0.6, 0.9, 0.975, 0.999}) {
    CAPTURE(probability);
    const double cauchy = std::tan(std::numbers::pi * (probability - 0.5));
    const double two = (2.0 * probability - 1.0) / std::sqrt(2.0 * probability * (1.0 - probability));
    for (const auto& [freedom, t] : {std::pair{1.0, cauchy}, std::pair{2.0, two}}) {
      CAPTURE(freedom);
      CHECK(student_quantile(freedom, probability) == doctest::Approx(t).epsilon(100.0 * round_off));
      CHECK(student_probability(freedom, t) == doctest::Approx(probability).epsilon(round_off));
      CHECK(student_probability(freedom, -t) == doctest::Approx(1.0 - probability).epsilon(100.0 * round_off));
    }
  }
}

TEST_CASE("What Student's distribution does not have is NaN") {
  CHECK(std::isnan(student_quantile(0.0, 0.9)));
  CHECK(std::isnan(student_quantile(std::nan(""), 0.9)));
  for (const double probability : {0.0, 1.0, std::nan("")}) {
    CHECK(std::isnan(student_quantile(3.0, probability)));
  }
  CHECK(std::isnan(student_probability(-1.0, 0.0)));
}
