// What makes a portable build fast: a hot loop is compiled for several instruction sets, and the widest that the
// machine has is picked at load time. Two ways, one for loops that the compiler makes wide by itself, one for those in
// which it matters what stays in registers.
#pragma once

#include <cstddef>

// Not where the loader cannot do it: other platforms and C libraries, and under sanitizers, whose start-up the resolver
// functions break.
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
#define STICTION_SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define STICTION_SANITIZED
#endif
#endif

// AVX-512 and AVX2 with FMA: GCC knows them as levels since 12, Clang by their parts.
#if defined(__x86_64__) && defined(__linux__) && defined(__GLIBC__) && !defined(STICTION_SANITIZED)
#if defined(__clang__)
#define STICTION_WIDEST "avx512f,avx512vl,avx512dq,avx512bw,fma"
#define STICTION_WIDE "avx2,fma"
#elif defined(__GNUC__) && __GNUC__ >= 12
#define STICTION_WIDEST "arch=x86-64-v4"
#define STICTION_WIDE "arch=x86-64-v3"
#endif
#endif

/// Before a function of plain loops. Not by Clang, of which some versions lose what such a function calls.
#if defined(STICTION_WIDE) && !defined(__clang__)
#define STICTION_MULTIVERSION __attribute__((target_clones(STICTION_WIDEST, STICTION_WIDE, "default")))
#else
#define STICTION_MULTIVERSION
#endif

// Clang thinks that what only the loader picks is unused.
#if defined(__clang__)
#pragma clang diagnostic ignored "-Wunused-function"
#endif

/// Defines void name(parameters) as name_kernel<Width>(arguments), a template written in packs of so many numbers as a
/// register of the instruction set holds: GCC keeps wider ones in memory, 20 times slower.
#if defined(STICTION_WIDE)
#define STICTION_KERNEL(name, parameters, arguments)                                                            \
  __attribute__((target(STICTION_WIDEST))) void name parameters { name##_kernel<8> arguments; } /* AVX-512 */   \
  __attribute__((target(STICTION_WIDE))) void name parameters { name##_kernel<4> arguments; }   /* AVX2, FMA */ \
  __attribute__((target("default"))) void name parameters { name##_kernel<2> arguments; }
#else
#define STICTION_KERNEL(name, parameters, arguments) \
  void name parameters { name##_kernel<2> arguments; }
#endif

// What a hot loop is made of must become part of it, to be compiled for its instruction sets.
#define STICTION_INLINE __attribute__((always_inline)) inline

namespace stiction {

// Vector types of GCC and Clang, and the same at any address; written out, because attributes of a type that depends on
// a template are dropped.
template <std::size_t Width>
struct PackOf;
template <>
struct PackOf<2> {
  using Type = double __attribute__((vector_size(16)));
  struct __attribute__((packed, may_alias)) Anywhere {
    Type pack;
  };
};
template <>
struct PackOf<4> {
  using Type = double __attribute__((vector_size(32)));
  struct __attribute__((packed, may_alias)) Anywhere {
    Type pack;
  };
};
template <>
struct PackOf<8> {
  using Type = double __attribute__((vector_size(64)));
  struct __attribute__((packed, may_alias)) Anywhere {
    Type pack;
  };
};

/// Numbers that one instruction works on.
template <std::size_t Width>
using Pack = typename PackOf<Width>::Type;

inline constexpr std::size_t widest_pack = 8;

// Not by memcpy, which GCC takes to pieces before it knows the instruction set.
template <std::size_t Width>
STICTION_INLINE Pack<Width> load(const double* values) {
  return reinterpret_cast<const typename PackOf<Width>::Anywhere*>(values)->pack;
}

template <std::size_t Width>
STICTION_INLINE void store(const Pack<Width>& pack, double* values) {
  reinterpret_cast<typename PackOf<Width>::Anywhere*>(values)->pack = pack;
}

}  // namespace stiction
