// One macro compiles a hot loop for several instruction sets and picks the widest at load time, so that a portable
// build is fast. Empty where the loader cannot do it: other compilers and platforms, and under the thread sanitizer,
// whose start-up the resolver functions break.
#pragma once

#if defined(__x86_64__) && defined(__linux__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)
#define STICTION_MULTIVERSION __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define STICTION_MULTIVERSION
#endif
