#include "areal_overlaps.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace stiction {
namespace {

// Whether two ellipses overlap whose centres are r apart: they are apart where for some λ in (0, 1)
// λ (1 - λ) rᵀ [(1 - λ) A + λ B]⁻¹ r > 1, a function with one maximum (Perram & Wertheim, J. Comput. Phys. 58 (1985)
// 409), found here by golden section.
bool overlap(const Shape& a, double a_size, const Shape& b, double b_size, const Vector2& r) {
  const auto contact = [&](double at) {
    const double one = (1.0 - at) * a_size;
    const double other = at * b_size;
    const double xx = one * a.xx + other * b.xx;
    const double xy = one * a.xy + other * b.xy;
    const double yy = one * a.yy + other * b.yy;
    return at * (1.0 - at) * (yy * r.x() * r.x() - 2.0 * xy * r.x() * r.y() + xx * r.y() * r.y()) / (xx * yy - xy * xy);
  };
  // It is at most λ α and (1 - λ) β, α and β being rᵀ A⁻¹ r and rᵀ B⁻¹ r, and so at most 1/(1/α + 1/β).
  const auto inverse_square = [&](const Shape& shape, double size) {
    return size * (shape.xx * shape.yy - shape.xy * shape.xy) /
           (shape.yy * r.x() * r.x() - 2.0 * shape.xy * r.x() * r.y() + shape.xx * r.y() * r.y());
  };
  if (inverse_square(a, a_size) + inverse_square(b, b_size) >= 1.0) {
    return true;
  }
  constexpr double golden = 0.6180339887498949;
  double low = 0.0;
  double high = 1.0;
  double left = 1.0 - golden;
  double right = golden;
  double at_left = contact(left);
  double at_right = contact(right);
  for (int i = 0; i < 25; ++i) {
    if (at_left > 1.0 || at_right > 1.0) {
      return false;
    }
    if (at_left > at_right) {
      high = right;
      right = left;
      at_right = at_left;
      left = high - golden * (high - low);
      at_left = contact(left);
    } else {
      low = left;
      left = right;
      at_left = at_right;
      right = low + golden * (high - low);
      at_right = contact(right);
    }
  }
  return true;
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
