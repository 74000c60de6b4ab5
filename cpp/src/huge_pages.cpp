#include "huge_pages.hpp"

#include <cstdint>

#if defined(__linux__)
#include <sys/mman.h>
#include <unistd.h>
#endif

namespace stiction {
namespace {

// Smaller arrays gain little, because the caches of the processor hold the addresses of their pages.
constexpr std::size_t min_huge_bytes = std::size_t{1} << 22;

}  // namespace

void request_huge_pages([[maybe_unused]] void* memory, [[maybe_unused]] std::size_t bytes) {
#if defined(__linux__) && defined(MADV_HUGEPAGE)
  if (bytes < min_huge_bytes) {
    return;
  }
  const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
  const auto begin = reinterpret_cast<std::uintptr_t>(memory);
  const std::size_t skipped = (page - begin % page) % page;
  // A failed request is no error: the array then has small pages.
  static_cast<void>(madvise(static_cast<std::byte*>(memory) + skipped, (bytes - skipped) / page * page, MADV_HUGEPAGE));
#endif
}

}  // namespace stiction
