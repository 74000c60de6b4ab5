// What makes a portable build fast: a hot loop is compiled for several instruction sets, and the widest that the
// machine has is picked at load time. Two ways, one for loops that the compiler makes wide by itself, one for those in
// which it matters what stays in registers.
#pragma once

#include <cstddef>

// Not where the loader cannot do it: other compilers and platforms, and under sanitizers, whose start-up the resolver
// functions break.
#if defined(__x86_64__) && defined(__linux__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)

/// Before a function of plain loops.
#define STICTION_MULTIVERSION __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))

/// Defines void name(parameters) as name_kernel<Width>(arguments), a template written in packs of so many numbers as a
/// register of the instruction set holds: GCC keeps wider ones in memory, 20 times slower.
#define STICTION_KERNEL(name, parameters, arguments)                                                             \
  __attribute__((target("arch=x86-64-v4"))) void name parameters { name##_kernel<8> arguments; } /* AVX-512 */   \
  __attribute__((target("arch=x86-64-v3"))) void name parameters { name##_kernel<4> arguments; } /* AVX2, FMA */ \
  __attribute__((target("default"))) void name parameters { name##_kernel<2> arguments; }

#else
#define STICTION_MULTIVERSION
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
