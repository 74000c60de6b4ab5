// Fuzz test of the core functions with arbitrary numbers.
// Core functions must throw std::invalid_argument or return results that satisfy the checked invariants.
#include "stiction/amplitude.hpp"
#include "stiction/areal.hpp"
#include "stiction/asperity.hpp"
#include "stiction/contact.hpp"
#include "stiction/harmonics.hpp"
#include "stiction/spline.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <variant>
#include <vector>

namespace {

void require(bool condition, const char* invariant) {
  if (!condition) {
    std::fprintf(stderr, "violated invariant: %s\n", invariant);
    std::abort();
  }
}

// Numbers decoded from the fuzzer's bytes. Most lie in [-1, 1). The others have any magnitude or are not finite.
class Source {
 public:
  Source(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}

  std::uint8_t byte() {
    if (size_ == 0) {
      return 0;
    }
    --size_;
    return *data_++;
  }

  std::size_t below(std::size_t limit) { return (byte() + 256U * byte()) % limit; }

  double number() {
    const std::uint8_t kind = byte();
    if (kind < 16) {
      std::uint64_t bits = 0;
      for (int i = 0; i < 8; ++i) {
        bits = bits << 8 | byte();
      }
      return std::bit_cast<double>(bits);
    }
    const double mantissa = (byte() - 128 + byte() / 256.0) / 128.0;
    return kind < 32 ? std::ldexp(mantissa, byte() - 128) : mantissa;
  }

  double positive() {
    const double value = number();
    return value < 0.0 ? -value : value;
  }

  std::vector<double> numbers(std::size_t count) {
    std::vector<double> values(count);
    for (double& value : values) {
      value = number();
    }
    return values;
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
};

stiction::ContactModel make_model(Source& source) {
  stiction::Law law = stiction::HertzSphere{source.positive()};
  switch (source.byte() % 3) {
    case 1:
      law = stiction::HertzCylinder{source.positive(), source.positive()};
      break;
    case 2:
      law = stiction::JacksonGreen{source.positive(), source.positive(), source.number()};
      break;
    default:
      break;
  }
  const std::uint8_t choices = source.byte();
  return {law,
          (choices & 1U) != 0 ? stiction::Detection::cell : stiction::Detection::gap_minimum,
          (choices & 2U) != 0 ? stiction::Curvature::convex : stiction::Curvature::signed_,
          {(choices & 4U) != 0 ? 1.0 : -1.0, 0.0}};
}

void fuzz_contact(Source& source) {
  const std::size_t points = source.below(400);
  const std::vector<double> upper = source.numbers(points);
  const std::vector<double> lower = source.numbers(points + (source.byte() == 1 ? 1 : 0));
  std::vector<double> approaches = source.numbers(source.below(6));
  for (double& approach : approaches) {
    approach = std::abs(approach);
  }
  std::sort(approaches.begin(), approaches.end());
  const double spacing = source.positive();
  const stiction::ContactModel model = make_model(source);
  const stiction::ProfilePair pair{upper, lower, spacing};
  const std::vector<stiction::Sums> sums = stiction::press(pair, approaches, model);
  for (std::size_t k = 0; k < approaches.size(); ++k) {
    require(sums[k].contact_count >= 0 && sums[k].contact_count <= static_cast<stiction::Index>(points),
            "no more contacts than points");
    require(!(sums[k].contact_area < 0.0), "no negative area");
    const std::vector<stiction::Contact> table = stiction::contacts(pair, approaches[k], model);
    // The candidates of `contacts` have gaps up to `approaches[k]`; those of `press`, up to the largest approach.
    require(static_cast<stiction::Index>(table.size()) == sums[k].contact_count, "contacts and press agree");
    for (const stiction::Contact& contact : table) {
      require(contact.overlap > 0.0 && contact.radii.minor > 0.0, "contacts overlap and are convex together");
      require(contact.normal.z() > 0.0, "normals point upwards");
    }
  }
}

// Two height maps of arbitrary magnitude, with some equal heights and some level regions.
struct Maps {
  stiction::Matrix upper;
  stiction::Matrix lower;

  explicit Maps(Source& source)
      : upper(static_cast<stiction::Index>(4 + source.below(16)), static_cast<stiction::Index>(4 + source.below(16))),
        lower(upper.rows(), upper.cols()) {
    const double scale = std::ldexp(1.0, source.byte() - 128);
    const bool flat = source.byte() % 4 == 0;
    const std::uint8_t level = source.byte();
    for (stiction::Index i = 0; i < upper.size(); ++i) {
      const bool tie = i > 0 && source.byte() < level;
      upper.data()[i] = tie ? upper.data()[i - 1] : scale * source.number();
      lower.data()[i] = flat ? 0.0 : (source.byte() < level ? upper.data()[i] : scale * source.number());
    }
  }
};

void check_sums(const std::vector<stiction::Contact>& table, const stiction::ArealSums& sums,
                const stiction::Vector2& direction, stiction::Sliding sliding) {
  require(static_cast<stiction::Index>(table.size()) == sums.contact_count, "contacts and press agree");
  stiction::ArealSums expected;
  double force = 0.0;
  double area = 0.0;
  for (const stiction::Contact& contact : table) {
    require(contact.overlap > 0.0 && contact.normal.z() > 0.0, "contacts overlap and their normals point upwards");
    require(std::abs(contact.tangent.dot(contact.normal)) < 1e-14, "tangents are perpendicular to the normals");
    require(std::abs(contact.tangent.norm() - 1.0) < 1e-14, "tangents are of unit length");
    force += contact.force;
    area += contact.area;
    expected.normal_elastic += contact.force * contact.normal.z();
    if (sliding == stiction::Sliding::all || contact.opposing) {
      expected.tangential_elastic -= contact.force * contact.normal.head<2>().dot(direction);
      expected.normal_frictional += contact.force * contact.tangent.z();
      expected.tangential_frictional -= contact.force * contact.tangent.head<2>().dot(direction);
      expected.tangential_adhesive -= contact.area * contact.tangent.head<2>().dot(direction);
    }
  }
  const auto check_close = [](double value, double expected_value, double size, const char* quantity) {
    require(!std::isfinite(size) || std::abs(value - expected_value) <= 1e-12 * size + 1e-300, quantity);
  };
  check_close(area, sums.contact_area, area, "area");
  check_close(expected.normal_elastic, sums.normal_elastic, force, "normal elastic");
  check_close(expected.tangential_elastic, sums.tangential_elastic, force, "tangential elastic");
  check_close(expected.normal_frictional, sums.normal_frictional, force, "normal frictional");
  check_close(expected.tangential_frictional, sums.tangential_frictional, force, "tangential frictional");
  check_close(expected.tangential_adhesive, sums.tangential_adhesive, area, "tangential adhesive");
}

void fuzz_areal(Source& source) {
  const Maps maps(source);
  const stiction::SurfacePair pair{maps.upper, maps.lower, {source.positive(), source.positive()}};
  const stiction::ContactModel model = make_model(source);
  const double deepest = 2.0 * (maps.upper - maps.lower).cwiseAbs().maxCoeff() * source.positive();
  const stiction::ArealCandidates candidates = stiction::candidates(pair, deepest, model.curvature);
  for (const stiction::ArealCandidate& candidate : candidates.all) {
    require(candidate.gap <= candidates.deepest && candidate.radii.minor > 0.0,
            "minima lie below the largest approach and are concave up");
    require(candidate.radii.major >= candidate.radii.minor && std::isfinite(candidate.radii.major),
            "the larger radius is the major one");
    require(candidate.row >= 0 && candidate.row + 1 < maps.upper.rows() && candidate.column >= 0 &&
                candidate.column + 1 < maps.upper.cols(),
            "minima lie in the map");
  }
  // On a steep wall, a contact ellipse is so narrow in plan view that round-off changes its fraction inside the map.
  const bool steep =
      std::any_of(candidates.all.begin(), candidates.all.end(), [](const stiction::ArealCandidate& candidate) {
        return candidate.normal.z() < 1e-5 || candidate.radii.major > 1e12 * candidate.radii.minor;
      });
  std::vector<double> approaches;
  const double steps = 1.0 + static_cast<double>(source.below(7));
  for (double step = 0.0; step < steps; ++step) {
    approaches.push_back(candidates.deepest * (step + 0.5) / steps);
  }
  const double angle = source.number();
  const std::vector<stiction::Vector2> directions{{1.0, 0.0}, {0.0, -1.0}, {std::cos(angle), std::sin(angle)}};
  const auto sliding = source.byte() % 2 == 0 ? stiction::Sliding::all : stiction::Sliding::opposing;
  const std::vector<stiction::ArealSums> sums = stiction::press(candidates, approaches, model.law, directions, sliding);
  require(sums.size() == directions.size() * approaches.size(), "one row of sums for each direction and approach");
  for (std::size_t k = 0; k < approaches.size(); ++k) {
    const stiction::ArealSums& row = sums[k];
    const double round_off_factor = 1.0 + 1e-12;
    const double min_normal = 1e-300;  // round-off of denormal numbers
    require(!(row.contact_area < 0.0), "no negative area");
    require(row.unanswered_count <= row.grid_minimum_count, "no more unanswered minima than grid minima");
    require(!(row.load_at_edge > round_off_factor * row.normal_elastic),
            "the load at the edge is a fraction of the load");
    require(!(row.load_overlapping > round_off_factor * row.normal_elastic),
            "the overlapping load is a fraction of the load");
    require(k == 0 || row.contact_count >= sums[k - 1].contact_count,
            "the number of contacts increases with the approach");
    if (std::holds_alternative<stiction::HertzSphere>(model.law) && !steep) {
      require(k == 0 || !(round_off_factor * row.normal_elastic + min_normal < sums[k - 1].normal_elastic),
              "the load increases with the approach");
      require(k == 0 || !(round_off_factor * row.contact_area + min_normal < sums[k - 1].contact_area),
              "the area increases with the approach");
    }
    for (std::size_t d = 0; d < directions.size(); ++d) {
      check_sums(stiction::contacts(candidates, approaches[k], model.law, directions[d]),
                 sums[d * approaches.size() + k], directions[d], sliding);
    }
  }
}

void fuzz_spline(Source& source) {
  const std::vector<double> heights = source.numbers(source.below(300));
  const double spacing = source.positive();
  std::vector<double> slope(heights.size());
  std::vector<double> curvature(heights.size());
  stiction::natural_spline(heights, spacing, slope, curvature);
  const std::size_t count = source.below(heights.size() + 2);
  std::vector<double> range_slope(count);
  std::vector<double> range_curvature(count);
  stiction::natural_spline_from(heights, spacing, static_cast<stiction::Index>(source.below(300)) - 2, range_slope,
                                range_curvature);
  stiction::asperities(heights, spacing, stiction::Side::upper);
}

void fuzz_harmonics(Source& source) {
  const auto directions = static_cast<stiction::Index>(source.below(6));
  const auto frequencies = static_cast<stiction::Index>(source.below(6));
  const auto rows = static_cast<stiction::Index>(source.below(7));
  const std::vector<double> phases = source.numbers(static_cast<std::size_t>(directions * frequencies));
  const std::vector<double> weights = source.numbers(static_cast<std::size_t>(rows * frequencies));
  const auto points = static_cast<stiction::Index>(source.below(3000));
  const stiction::HarmonicGrid grid{source.positive(), points, source.positive(), 1.0 + source.positive(),
                                    source.byte() % 2 == 0};
  const stiction::Matrix profiles =
      stiction::harmonic_profiles(Eigen::Map<const stiction::Matrix>(phases.data(), directions, frequencies),
                                  Eigen::Map<const stiction::Matrix>(weights.data(), rows, frequencies), grid);
  require(profiles.rows() == rows && profiles.cols() == points,
          "one row for each row of weights, one column for each point");
  stiction::frequency_weights(source.number(), frequencies, 1.0 + source.positive(), source.positive());
}

void fuzz_amplitude(Source& source) {
  const std::vector<double> heights = source.numbers(source.below(200));
  std::vector<double> scaled(heights.size());
  stiction::scale_to_amplitude(heights, source.number(), static_cast<stiction::AmplitudeMeasure>(source.byte() % 3),
                               scaled);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Source source(data, size);
  try {
    switch (source.byte() % 8) {
      case 0:
        fuzz_spline(source);
        break;
      case 1:
        fuzz_harmonics(source);
        break;
      case 2:
        fuzz_amplitude(source);
        break;
      case 3:
      case 4:
        fuzz_areal(source);
        break;
      default:
        fuzz_contact(source);
        break;
    }
  } catch (const std::invalid_argument&) {
  }
  return 0;
}
