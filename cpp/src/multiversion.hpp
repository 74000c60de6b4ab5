// Function multiversioning: hot loops are compiled for several instruction sets.
// The loader selects the version of each function for the widest instruction set that the machine supports.
// STICTION_MULTIVERSION is for plain loops, STICTION_KERNEL for loops that must keep values in SIMD registers.
#pragma once

#include <cstddef>

// Multiversioning requires the GNU loader on x86-64 Linux, and is incompatible with the start-up code of sanitizers.
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
#define STICTION_SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define STICTION_SANITIZED
#endif
#endif

// The targets are AVX-512, and AVX2 with FMA. GCC 12 and later accept x86-64 levels. Clang requires a list of features.
#if defined(__x86_64__) && defined(__linux__) && defined(__GLIBC__) && !defined(STICTION_SANITIZED)
#if defined(__clang__)
#define STICTION_WIDEST "avx512f,avx512vl,avx512dq,avx512bw,fma"
#define STICTION_WIDE "avx2,fma"
#elif defined(__GNUC__) && __GNUC__ >= 12
#define STICTION_WIDEST "arch=x86-64-v4"
#define STICTION_WIDE "arch=x86-64-v3"
#endif
#endif

/// STICTION_MULTIVERSION is empty for Clang, because some versions of Clang omit functions that a clone calls.
#if defined(STICTION_WIDE) && !defined(__clang__)
#define STICTION_MULTIVERSION __attribute__((target_clones(STICTION_WIDEST, STICTION_WIDE, "default")))
#else
#define STICTION_MULTIVERSION
#endif

// Clang would report a function as unused if only the loader calls it.
#if defined(__clang__)
#pragma clang diagnostic ignored "-Wunused-function"
#endif

/// Define `void name(parameters)` from the template `name_kernel<Width>(arguments)`, for Width doubles per register.
/// GCC stores a SIMD value in memory if it is wider than a register, which makes access 20 times slower.
#if defined(STICTION_WIDE)
#define STICTION_KERNEL(name, parameters, arguments)                                                            \
  __attribute__((target(STICTION_WIDEST))) void name parameters { name##_kernel<8> arguments; } /* AVX-512 */   \
  __attribute__((target(STICTION_WIDE))) void name parameters { name##_kernel<4> arguments; }   /* AVX2, FMA */ \
  __attribute__((target("default"))) void name parameters { name##_kernel<2> arguments; }
#else
#define STICTION_KERNEL(name, parameters, arguments) \
  void name parameters { name##_kernel<2> arguments; }
#endif

// Inlined functions are compiled for the instruction sets of the loop that calls them.
#define STICTION_INLINE __attribute__((always_inline)) inline

namespace stiction {

// Each SIMD width has its own type, because compilers ignore attributes of types that depend on a template parameter.
template <std::size_t Width>
struct PackOf;
template <>
struct PackOf<2> {
  using Type = double __attribute__((vector_size(16)));
  struct __attribute__((packed, may_alias)) Unaligned {
    Type pack;
  };
};
template <>
struct PackOf<4> {
  using Type = double __attribute__((vector_size(32)));
  struct __attribute__((packed, may_alias)) Unaligned {
    Type pack;
  };
};
template <>
struct PackOf<8> {
  using Type = double __attribute__((vector_size(64)));
  struct __attribute__((packed, may_alias)) Unaligned {
    Type pack;
  };
};

template <std::size_t Width>
using Pack = typename PackOf<Width>::Type;

inline constexpr std::size_t widest_pack = 8;

// std::memcpy is not used: GCC would split the copy into small copies before it knows the instruction set.
template <std::size_t Width>
STICTION_INLINE Pack<Width> load(const double* values) {
  return reinterpret_cast<const typename PackOf<Width>::Unaligned*>(values)->pack;
}

template <std::size_t Width>
STICTION_INLINE void store(const Pack<Width>& pack, double* values) {
  reinterpret_cast<typename PackOf<Width>::Unaligned*>(values)->pack = pack;
}

}  // namespace stiction
