// Loops that are compiled for more than one instruction set.
#pragma once

/// Compiles a function for AVX-512 and AVX2 besides, chosen when the program starts. The results are equal: nothing
/// leaves rounding to the compiler (-ffp-contract=off). Not where sanitizers or clang do not know the attribute.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define LANDFIX_VECTORIZED __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define LANDFIX_VECTORIZED
#endif
