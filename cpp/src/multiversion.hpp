// What makes a portable build fast: one macro compiles a hot loop for several instruction sets and picks the widest at
// load time, and a pack of numbers is what such a loop keeps in a register, whatever its width.
#pragma once

#include "stiction/array.hpp"

// Empty where the loader cannot do it: other compilers and platforms, and under sanitizers, whose start-up the resolver
// functions break.
#if defined(__x86_64__) && defined(__linux__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)
#define STICTION_MULTIVERSION __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define STICTION_MULTIVERSION
#endif

// What a hot loop is made of must become part of it, to be compiled for its instruction sets.
#define STICTION_INLINE __attribute__((always_inline)) inline

namespace stiction {

/// Eight numbers, in one register of AVX-512, two of AVX or four of SSE (a vector type of GCC and Clang).
inline constexpr Index pack_size = 8;
using Pack = double __attribute__((vector_size(pack_size * sizeof(double)), aligned(sizeof(double))));

STICTION_INLINE const Pack& load(const double* values) { return *reinterpret_cast<const Pack*>(values); }
STICTION_INLINE void store(const Pack& pack, double* values) { *reinterpret_cast<Pack*>(values) = pack; }

}  // namespace stiction
