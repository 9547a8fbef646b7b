#pragma once

/// ISOCHOR_MULTIVERSION before a function compiles its loops for AVX2 and for the baseline, chosen when the
/// program starts, so that one build serves every machine. Contraction is off (CMakeLists.txt), so both give
/// the same bits. Sanitizers and clang take the baseline: their ifunc support is not reliable.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define ISOCHOR_MULTIVERSION __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define ISOCHOR_MULTIVERSION
#endif
