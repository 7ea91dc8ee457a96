/// KAGERO_INLINE marks functions that the compiler must inline at every call.
#pragma once

#ifdef KAGERO_SANITIZED  // sanitizer checks enlarge inlined code so much that it would compile too slowly
#define KAGERO_INLINE inline
#else
#define KAGERO_INLINE inline __attribute__((always_inline))
#endif
