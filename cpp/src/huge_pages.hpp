// Huge memory pages for large arrays.
#pragma once

#include <cstddef>
#include <vector>

namespace stiction {

/// Ask Linux to use memory pages of 2 MiB for an array that has not been written yet. Small arrays are left unchanged.
/// A column of a large grid then needs fewer address translations, and the system clears memory in fewer steps.
void request_huge_pages(void* memory, std::size_t bytes);

/// Resize an array. If it needs new memory, its contents are discarded.
template <class T>
void resize_on_huge_pages(std::vector<T>& values, std::size_t size) {
  if (values.capacity() < size) {
    values = std::vector<T>();
    values.reserve(size);
    request_huge_pages(values.data(), size * sizeof(T));
  }
  values.resize(size);
}

}  // namespace stiction
