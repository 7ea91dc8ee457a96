/// KAGERO_ASSERT checks invariants in development builds.
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

/// Prints the condition, file and line, and aborts, if the condition is false. The condition must have no side effects:
/// release builds do not evaluate it. Invalid input is not an assertion failure but an InputError, in every build.
#define KAGERO_ASSERT(condition) ((condition) ? void() : ::kagero::assertion_failed(#condition, __FILE__, __LINE__))
#else
#define KAGERO_ASSERT(condition) static_cast<void>(sizeof((condition) ? 1 : 0))
#endif
