/// Declares the Hamiltonians of this build, in the order of `hamiltonians.inc`. The build generates that file from the
/// headers in kernels/hamiltonians.
#pragma once

#define KAGERO_HAMILTONIAN(TYPE)     \
    namespace kagero::hamiltonians { \
    struct TYPE;                     \
    }
#include "hamiltonians.inc"
#undef KAGERO_HAMILTONIAN
