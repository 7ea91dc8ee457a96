#include "modules/space.h"

namespace kagero {

Hole Space::hole() const {
    Hole hole = module->hole(hamiltonian, parameters.data());
    hole.spin *= time_sign;
    return hole;
}

RayStart Space::start(const double (&q)[3], const std::array<double, 3>& d) const {
    RayStart start{};
    module->start(hamiltonian, parameters.data(), q, d.data(), &start);
    return start;
}

}  // namespace kagero
