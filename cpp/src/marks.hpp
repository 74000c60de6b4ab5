// Marks of a pass over many points, of which few are set.
#pragma once

#include "stiction/array.hpp"

#include <cstdint>
#include <cstring>

namespace stiction {

/// Calls visit(i) for every i from begin to end, excluded, whose mark is not 0.
template <class Visit>
void for_each_marked(const unsigned char* marks, Index begin, Index end, const Visit& visit) {
  constexpr Index at_once = sizeof(std::uint64_t);
  for (Index i = begin; i < end;) {
    std::uint64_t some = 1;
    if (i + at_once <= end) {
      std::memcpy(&some, marks + i, sizeof(some));
    }
    const Index stop = some == 0 ? i : (i + at_once <= end ? i + at_once : end);
    for (Index k = i; k < stop; ++k) {
      if (marks[k] != 0) {
        visit(k);
      }
    }
    i = some == 0 ? i + at_once : stop;
  }
}

}  // namespace stiction
