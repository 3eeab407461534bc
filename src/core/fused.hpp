// Functions of set-up with many fused multiply-adds. At the baseline each of these is a call of the C library
// (core/level.hpp).
#pragma once

/// Compiles a function a second time for x86-64-v3, whose instructions it has there in all that can be inlined into it,
/// in the section where tests/architecture/levels_test.py expects them. Bits are the same. The processor chooses at
/// start, which sanitizers do not allow.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) &&               \
    !defined(__SANITIZE_THREAD__)
#define SKEIN_FUSED [[gnu::target_clones("default", "arch=x86-64-v3"), gnu::flatten, gnu::section("skein_x86_64_v3")]]
#else
#define SKEIN_FUSED
#endif
