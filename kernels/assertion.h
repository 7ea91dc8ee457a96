/// Invariants that development builds check.
#pragma once

#ifdef KAGERO_ASSERTIONS
#include <cstdio>
#include <cstdlib>

namespace kagero {

[[noreturn]] inline void assertion_failed(const char* condition, const char* file, int line) {
    std::fprintf(stderr, "kagero: %s:%d: assertion failed: %s\n", file, line, condition);
    std::abort();
}

}  // namespace kagero

/// Ends the process with the condition and its place where the condition is false; free of side effects. Release builds
/// do not evaluate it: they check input, which is reported as an InputError, and trust invariants.
#define KAGERO_ASSERT(condition) ((condition) ? void() : ::kagero::assertion_failed(#condition, __FILE__, __LINE__))
#else
#define KAGERO_ASSERT(condition) static_cast<void>(sizeof((condition) ? 1 : 0))
#endif
