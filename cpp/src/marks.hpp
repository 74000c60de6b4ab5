// Fast iteration over the marked elements of an array in which few elements are marked.
#pragma once

#include "stiction/values.hpp"

#include <cstdint>
#include <cstring>

namespace stiction {

/// Call `visit(i)` for every index i from `begin` to `end - 1` whose mark is not 0. Tests eight marks at a time.
template <class Visit>
void for_each_marked(const unsigned char* marks, Index begin, Index end, const Visit& visit) {
  constexpr Index marks_per_word = sizeof(std::uint64_t);
  for (Index i = begin; i < end;) {
    std::uint64_t word = 1;
    if (i + marks_per_word <= end) {
      std::memcpy(&word, marks + i, sizeof(word));
    }
    const Index stop = word == 0 ? i : (i + marks_per_word <= end ? i + marks_per_word : end);
    for (Index k = i; k < stop; ++k) {
      if (marks[k] != 0) {
        visit(k);
      }
    }
    i = word == 0 ? i + marks_per_word : stop;
  }
}

}  // namespace stiction
