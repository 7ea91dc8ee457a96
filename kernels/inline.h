/// Functions that are inlined wherever they are used.
#pragma once

#ifdef KAGERO_SANITIZED  // checks multiply what is inlined, and with it the time of compiling
#define KAGERO_INLINE inline
#else
#define KAGERO_INLINE inline __attribute__((always_inline))
#endif
