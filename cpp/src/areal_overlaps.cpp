#include "areal_overlaps.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace stiction {
namespace {

// Whether two ellipses overlap whose centres are r apart: they are apart where for some t in (0, 1)
// t (1 - t) rᵀ [(1 - t) A + t B]⁻¹ r > 1 (Perram & Wertheim, J. Comput. Phys. 58 (1985) 409). Times the determinant of
// what is in brackets that is a cubic above 0, whose ends are below.
bool overlap(const Shape& a, double a_size, const Shape& b, double b_size, const Vector2& r) {
  const auto of_a = a_size * (a.yy * r.x() * r.x() - 2.0 * a.xy * r.x() * r.y() + a.xx * r.y() * r.y());
  const auto of_b = b_size * (b.yy * r.x() * r.x() - 2.0 * b.xy * r.x() * r.y() + b.xx * r.y() * r.y());
  const double square_a = a_size * a_size * (a.xx * a.yy - a.xy * a.xy);
  const double square_b = b_size * b_size * (b.xx * b.yy - b.xy * b.xy);
  const double mixed = a_size * b_size * (a.xx * b.yy + a.yy * b.xx - 2.0 * a.xy * b.xy);
  const double first = of_a + 2.0 * square_a - mixed;
  const double second = of_b - 2.0 * of_a - square_a - square_b + mixed;
  const double third = of_a - of_b;
  const double discriminant = second * second - 3.0 * first * third;
  if (!(discriminant > 0.0)) {
    return true;
  }
  const double root = std::sqrt(discriminant);
  const double t = second < 0.0 ? first / (root - second) : -(root + second) / (3.0 * third);  // of the maximum
  const double s = 1.0 - t;
  const bool apart =
      t > 0.0 && s > 0.0 && s * t * (s * of_a + t * of_b) > s * s * square_a + s * t * mixed + t * t * square_b;
  return !apart;
}

}  // namespace

Shape shape_of(const ArealCandidate& candidate) {
  const Vector3 across = candidate.normal.cross(candidate.along);
  const auto entry = [&](Index i, Index j) {
    return candidate.ellipse.major * candidate.along[i] * candidate.along[j] +
           candidate.ellipse.minor * across[i] * across[j];
  };
  return {entry(0, 0), entry(0, 1), entry(1, 1)};
}

std::size_t first_step(const ArealCandidate& candidate, Values approaches) {
  return static_cast<std::size_t>(std::upper_bound(approaches.begin(), approaches.end(), candidate.gap) -
                                  approaches.begin());
}

// Ellipses grow with the approach about their centres, so once overlapping they are so for ever.
std::vector<std::size_t> first_overlaps(const std::vector<ArealCandidate>& all, Values approaches,
                                        const Checkpoint& checkpoint) {
  struct Seen {
    std::size_t index;
    std::size_t begin;
    Shape shape;
    double left;
    double right;
    double half_height;
  };
  std::vector<Seen> seen;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::size_t begin = first_step(all[i], approaches);
    if (begin < approaches.size()) {
      const Shape shape = shape_of(all[i]);
      const double size = all[i].overlap(approaches.back());
      const double reach = std::sqrt(shape.xx * size);
      const double x = all[i].position.x();
      seen.push_back({i, begin, shape, x - reach, x + reach, std::sqrt(shape.yy * size)});
    }
  }
  std::sort(seen.begin(), seen.end(), [](const Seen& a, const Seen& b) { return a.left < b.left; });
  std::vector<std::size_t> first(all.size(), approaches.size());
  for (std::size_t i = 0; i < seen.size(); ++i) {
    checkpoint();
    const Seen& one = seen[i];
    const ArealCandidate& a = all[one.index];
    for (std::size_t j = i + 1; j < seen.size() && seen[j].left <= one.right; ++j) {
      const Seen& other = seen[j];
      const ArealCandidate& b = all[other.index];
      const Vector2 apart = (b.position - a.position).head<2>();
      const auto at = [&](std::size_t k) {
        return overlap(one.shape, a.overlap(approaches[k]), other.shape, b.overlap(approaches[k]), apart);
      };
      // Nothing new is to be learned at and behind the later of what is known of the two.
      std::size_t begin = std::max(one.begin, other.begin);
      std::size_t end = std::max(first[one.index], first[other.index]);
      if (begin >= end || std::abs(apart.y()) > one.half_height + other.half_height || !at(end - 1)) {
        continue;
      }
      --end;
      while (begin < end) {
        const std::size_t middle = (begin + end) / 2;
        if (at(middle)) {
          end = middle;
        } else {
          begin = middle + 1;
        }
      }
      first[one.index] = std::min(first[one.index], end);
      first[other.index] = std::min(first[other.index], end);
    }
  }
  return first;
}

}  // namespace stiction
