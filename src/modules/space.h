/// The space of a scene: a Hamiltonian of a kernel module with values for its parameters.
#pragma once

#include "kernels/abi.h"

#include <array>
#include <string>
#include <vector>

namespace kagero {

/// Returns the index of a Hamiltonian in Module::hamiltonians. Throws InputError if the module has none of this name.
std::uint32_t hamiltonian_index(const Module& module, const std::string& name);

/// A space. Positions and momenta are relative to the origin of the Hamiltonian, in its unit of length.
struct Space {
    const Module* module = nullptr;
    std::uint32_t hamiltonian = 0;   ///< Index into Module::hamiltonians.
    /// Values in declared order. For a formula: the memory of its programs as Module::compile has written it.
    std::vector<double> parameters;

    const HamiltonianInfo& info() const { return module->hamiltonians[hamiltonian]; }
    /// Returns true if every ray is straight with these parameters.
    bool is_straight() const { return module->straight(hamiltonian, parameters.data()); }
    /// Returns the radius |q| of the throat of a wormhole; the second sheet is mapped into this sphere by inversion.
    /// Returns 0 if there is no second sheet.
    double throat_radius() const { return module->throat_radius(hamiltonian, parameters.data()); }
    /// Returns the radius |q| beyond which rays are straight; infinity if the Hamiltonian declares no such radius.
    double bending_radius() const { return module->bending_radius(hamiltonian, parameters.data()); }
    /// Returns the black hole at the origin.
    Hole hole() const { return module->hole(hamiltonian, parameters.data()); }
    /// Returns the frequency of the light at a ray's end, as measured by matter that moves with velocity dx/dt.
    double frequency(const RayEnd& end, const std::array<double, 3>& velocity) const {
        return module->frequency(hamiltonian, parameters.data(), end.q, end.p, end.pt, velocity.data());
    }
    /// Returns the ray start at q with dq/dλ along d. If there is none, RayStart::failure is the reason.
    RayStart start(const double (&q)[3], const std::array<double, 3>& d) const;
    /// Returns what the starts of rays at q share.
    StartPosition prepare_starts(const double (&q)[3]) const;
    /// Returns the same start as the other function, for a position that this space has prepared.
    RayStart start(const StartPosition& at, const std::array<double, 3>& d) const;
    /// Computes the map from directions in the rest frame of an observer at q to momenta, in ingoing or outgoing
    /// coordinates (Module::observe). Returns Failure::none, or the reason why the map does not exist.
    Failure observe(ObserverKind observer, const double (&q)[3], bool ingoing, StartMap& map) const {
        return module->observe(hamiltonian, parameters.data(), observer, q, ingoing, &map);
    }
};

}  // namespace kagero
