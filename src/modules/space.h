/// A Hamiltonian of a kernel module with the values of its parameters: what bends the light of a scene.
#pragma once

#include "kernels/abi.h"

#include <array>
#include <vector>

namespace kagero {

/// Positions and momenta are relative to the origin of the Hamiltonian, in its unit of length.
struct Space {
    const Module* module = nullptr;
    std::uint32_t hamiltonian = 0;   ///< an index into Module::hamiltonians
    std::vector<double> parameters;  ///< in the declared order; of a formula its compiled programs
    double time =
        1;  ///< −1: parameters are those of the space with time reversed, as rays of a falling observer need them

    const HamiltonianInfo& info() const { return module->hamiltonians[hamiltonian]; }
    /// Whether these parameters leave every ray straight.
    bool is_straight() const { return module->straight(hamiltonian, parameters.data()); }
    /// The radius of the sphere that the universe behind a throat lies in, by inversion; 0 where there is no such
    /// universe.
    double far_radius() const { return module->throat_radius(hamiltonian, parameters.data()); }
    /// The radius beyond which rays are straight; infinity where there is none.
    double bending_radius() const { return module->bends_within(hamiltonian, parameters.data()); }
    /// The hole at the origin, in the sense of time that the scene has.
    Hole hole() const;
    /// The frequency of the light of a ray's end, as seen by matter that moves with dx/dt = `velocity` there.
    double frequency(const RayEnd& end, const std::array<double, 3>& velocity) const {
        return module->frequency(hamiltonian, parameters.data(), end.q, end.p, end.pt, velocity.data(), time);
    }
    /// The state of a ray at q that moves along d, in coordinates; RayStart::failure states why there is none.
    RayStart start(const double (&q)[3], const std::array<double, 3>& d) const;
    /// The map from directions in the rest frame of an observer at q to momenta, or why there is no such observer.
    Failure observe(ObserverKind observer, const double (&q)[3], StartMap& map) const {
        return module->observe(hamiltonian, parameters.data(), observer, q, &map);
    }
};

}  // namespace kagero
