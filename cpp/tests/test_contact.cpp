#include "stiction/asperity.hpp"
#include "stiction/contact.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

using stiction::Contact;
using stiction::ContactModel;
using stiction::HertzSphere;

namespace {

const ContactModel hertz{HertzSphere{10.0}};

// `sign` is +1 for a bump of the lower surface, and -1 for a bump of the upper surface.
std::vector<double> arc(double apex, double radius, double spacing, std::size_t size, double sign) {
  std::vector<double> heights(size);
  for (std::size_t i = 0; i < size; ++i) {
    const double x = static_cast<double>(i) * spacing - apex;
    heights[i] = sign * (std::sqrt(radius * radius - x * x) - radius);
  }
  return heights;
}

}  // namespace

TEST_CASE("asperity: normals and radii point out of the solid for a slope of 3/4") {
  const auto lower = stiction::asperity(0.75, -0.5, stiction::Side::lower);
  CHECK(lower.normal.isApprox(stiction::Vector3(-0.6, 0.0, 0.8)));
  CHECK(lower.radius == doctest::Approx(2.0 * 1.25 * 1.25 * 1.25));
  const auto upper = stiction::asperity(0.75, -0.5, stiction::Side::upper);
  CHECK(upper.normal.isApprox(-lower.normal));
  CHECK(upper.radius == -lower.radius);
  CHECK(stiction::asperity(0.75, 0.0, stiction::Side::upper).radius == std::numeric_limits<double>::infinity());
}

TEST_CASE("press and contacts: agree for a single contact") {
  const auto lower = arc(1.0137, 3.0, 0.01, 201, +1.0);
  const auto upper = arc(0.9, 2.0, 0.01, 201, -1.0);
  for (const double shear : {+1.0, -1.0}) {
    ContactModel model = hertz;
    model.direction = {shear, 0.0};
    const std::vector<Contact> table = stiction::contacts({upper, lower, 0.01}, 1e-4, model);
    REQUIRE(table.size() == 1);
    const Contact& contact = table.front();
    const double approach = 1e-4;
    const auto sums = stiction::press({upper, lower, 0.01}, {&approach, 1}, model).front();
    CHECK(sums.contact_count == 1);
    CHECK(sums.contact_area == contact.area);
    CHECK(sums.normal_elastic == contact.force * contact.normal.z());
    const double opposing = contact.opposing ? 1.0 : 0.0;
    CHECK(sums.normal_frictional == opposing * contact.force * contact.tangent.z());
    CHECK(sums.tangential_adhesive == opposing * -shear * contact.area * contact.tangent.x());
    // The right flank of the upper arc touches the left flank of the lower arc: the contact opposes a motion along +x.
    CHECK(contact.opposing == (shear * contact.normal.x() < 0.0));
    CHECK(contact.normal.dot(contact.tangent) == doctest::Approx(0.0));
  }
}

TEST_CASE("press: invalid arrays, approaches and models throw with the name of the argument") {
  const std::vector<double> heights{0.0, 1.0, 0.0, 1.0, 0.0};
  const auto message = [&](const std::vector<double>& upper, const std::vector<double>& lower, double spacing,
                           const std::vector<double>& approaches, const ContactModel& model) -> std::string {
    try {
      stiction::press({upper, lower, spacing}, approaches, model);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  const auto mentions = [](const std::string& text, const char* word) { return text.find(word) != std::string::npos; };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const std::vector<double> good{0.0, 0.1};
  CHECK(message(heights, heights, 1.0, good, hertz).empty());
  CHECK(mentions(message(heights, {0.0, 1.0, 0.0, 1.0}, 1.0, good, hertz), "equal numbers of points"));
  CHECK(mentions(message({0.0, 1.0, 0.0}, {0.0, 1.0, 0.0}, 1.0, good, hertz), "at least 4"));
  CHECK(mentions(message({0.0, nan, 0.0, 1.0, 0.0}, heights, 1.0, good, hertz), "upper"));
  CHECK(mentions(message(heights, {0.0, 1.0, 0.0, 1.0, infinity}, 1.0, good, hertz), "lower"));
  CHECK(mentions(message(heights, heights, 0.0, good, hertz), "spacing"));
  CHECK(mentions(message(heights, heights, nan, good, hertz), "spacing"));
  CHECK(mentions(message(heights, heights, 1.0, {}, hertz), "approaches"));
  CHECK(mentions(message(heights, heights, 1.0, {-0.1}, hertz), "-0.1"));
  CHECK(mentions(message(heights, heights, 1.0, {nan}, hertz), "approach"));
  CHECK(mentions(message(heights, heights, 1.0, {0.2, 0.2}, hertz), "increase"));
  CHECK(mentions(message(heights, heights, 1.0, good, {HertzSphere{0.0}}), "effective_modulus"));
  CHECK(mentions(message(heights, heights, 1.0, good, {HertzSphere{nan}}), "effective_modulus"));
  CHECK(mentions(message(heights, heights, 1.0, good,
                         {HertzSphere{1.0}, stiction::Detection::cell, stiction::Curvature::convex, {0.5, 0.5}}),
                 "direction"));
}
