#include "areal_overlaps.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace stiction {
namespace {

// Two ellipses have the matrices A and B, and r is the vector between their centres.
// The two ellipses do not overlap if t (1 - t) rᵀ [(1 - t) A + t B]⁻¹ r > 1 for some t in (0, 1).
// Source: Perram & Wertheim, J. Comput. Phys. 58 (1985) 409.
// Multiplied by det[(1 - t) A + t B], this inequality states that the maximum of a cubic polynomial in t is positive.
bool ellipses_overlap(const ProjectedEllipse& a, double a_size, const ProjectedEllipse& b, double b_size,
                      const Vector2& r) {
  const auto a_form = a_size * (a.yy * r.x() * r.x() - 2.0 * a.xy * r.x() * r.y() + a.xx * r.y() * r.y());
  const auto b_form = b_size * (b.yy * r.x() * r.x() - 2.0 * b.xy * r.x() * r.y() + b.xx * r.y() * r.y());
  const double a_determinant = a_size * a_size * (a.xx * a.yy - a.xy * a.xy);
  const double b_determinant = b_size * b_size * (b.xx * b.yy - b.xy * b.xy);
  const double mixed_determinant = a_size * b_size * (a.xx * b.yy + a.yy * b.xx - 2.0 * a.xy * b.xy);
  const double first = a_form + 2.0 * a_determinant - mixed_determinant;
  const double second = b_form - 2.0 * a_form - a_determinant - b_determinant + mixed_determinant;
  const double third = a_form - b_form;
  const double discriminant = second * second - 3.0 * first * third;
  if (!(discriminant > 0.0)) {
    return true;
  }
  const double root = std::sqrt(discriminant);
  const double t = second < 0.0 ? first / (root - second) : -(root + second) / (3.0 * third);
  const double s = 1.0 - t;
  const bool apart =
      t > 0.0 && s > 0.0 &&
      s * t * (s * a_form + t * b_form) > s * s * a_determinant + s * t * mixed_determinant + t * t * b_determinant;
  return !apart;
}

}  // namespace

ProjectedEllipse projected_ellipse(const ArealCandidate& candidate) {
  const Vector3 across = candidate.normal.cross(candidate.along);
  const auto entry = [&](Index i, Index j) {
    return candidate.ellipse.major * candidate.along[i] * candidate.along[j] +
           candidate.ellipse.minor * across[i] * across[j];
  };
  return {entry(0, 0), entry(0, 1), entry(1, 1)};
}

std::size_t first_contact_step(const ArealCandidate& candidate, Values approaches) {
  return static_cast<std::size_t>(std::upper_bound(approaches.begin(), approaches.end(), candidate.gap) -
                                  approaches.begin());
}

// Ellipses that overlap at one approach overlap at all larger approaches, because they grow about fixed centres.
std::vector<std::size_t> first_overlaps(const std::vector<ArealCandidate>& all, Values approaches,
                                        const CancellationCheck& check_cancellation) {
  struct Footprint {
    std::size_t index;
    std::size_t begin;
    ProjectedEllipse shape;
    double left;
    double right;
    double half_height;
  };
  std::vector<Footprint> footprints;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::size_t begin = first_contact_step(all[i], approaches);
    if (begin < approaches.size()) {
      const ProjectedEllipse shape = projected_ellipse(all[i]);
      const double size = all[i].overlap(approaches.back());
      const double half_width = std::sqrt(shape.xx * size);
      const double x = all[i].position.x();
      footprints.push_back({i, begin, shape, x - half_width, x + half_width, std::sqrt(shape.yy * size)});
    }
  }
  std::sort(footprints.begin(), footprints.end(),
            [](const Footprint& a, const Footprint& b) { return a.left < b.left; });
  std::vector<std::size_t> first(all.size(), approaches.size());
  for (std::size_t i = 0; i < footprints.size(); ++i) {
    check_cancellation();
    const Footprint& left = footprints[i];
    const ArealCandidate& a = all[left.index];
    for (std::size_t j = i + 1; j < footprints.size() && footprints[j].left <= left.right; ++j) {
      const Footprint& right = footprints[j];
      const ArealCandidate& b = all[right.index];
      const Vector2 apart = (b.position - a.position).head<2>();
      const auto at = [&](std::size_t k) {
        return ellipses_overlap(left.shape, a.overlap(approaches[k]), right.shape, b.overlap(approaches[k]), apart);
      };
      // Approaches are skipped if both ellipses are already known to overlap other ellipses at these approaches.
      std::size_t begin = std::max(left.begin, right.begin);
      std::size_t end = std::max(first[left.index], first[right.index]);
      if (begin >= end || std::abs(apart.y()) > left.half_height + right.half_height || !at(end - 1)) {
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
      first[left.index] = std::min(first[left.index], end);
      first[right.index] = std::min(first[right.index], end);
    }
  }
  return first;
}

}  // namespace stiction
