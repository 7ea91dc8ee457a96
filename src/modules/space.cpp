#include "modules/space.h"

namespace kagero {

RayStart Space::start(const double (&q)[3], const std::array<double, 3>& d) const {
    RayStart start{};
    module->start(hamiltonian, parameters.data(), q, d.data(), &start);
    return start;
}

}  // namespace kagero
