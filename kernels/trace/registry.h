/// The Hamiltonians of this build, in the order of `hamiltonians.inc`, which the build writes from the headers it
/// finds.
#pragma once

#define KAGERO_HAMILTONIAN(TYPE)     \
    namespace kagero::hamiltonians { \
    struct TYPE;                     \
    }
#include "hamiltonians.inc"
#undef KAGERO_HAMILTONIAN
