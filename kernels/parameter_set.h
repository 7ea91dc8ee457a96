/// The space of a ray for which the Hamiltonian has parameters of its own. Part of the binary interface (abi.h).
#pragma once

namespace kagero {

/// The black hole at the origin of a space: mass GM/c² and spin a = J/(Mc) along +z, both lengths. Mass 0: no hole.
struct Hole {
    double mass = 0, spin = 0;
};

/// Values of the parameters of a Hamiltonian, with the members of Job that depend on them. The members have the same
/// meaning as in Job, whose members with these names are not used.
struct ParameterSet {
    const double* parameters;
    Hole hole;
    double escape_radius, inner_escape_radius, capture_radius, capture_stretch;
};

}  // namespace kagero
