#include "modules/space.h"

#include "error.h"

namespace kagero {

std::uint32_t hamiltonian_index(const Module& module, const std::string& name) {
    for (std::uint32_t i = 0; i < module.hamiltonian_count; ++i)
        if (name == module.hamiltonians[i].name) return i;
    throw InputError("the kernel module has no Hamiltonian '" + name + "'");
}

RayStart Space::start(const double (&q)[3], const std::array<double, 3>& d) const {
    RayStart start{};
    module->start(hamiltonian, parameters.data(), q, d.data(), &start);
    return start;
}

StartPosition Space::prepare_starts(const double (&q)[3]) const {
    StartPosition at{};
    module->prepare_starts(hamiltonian, parameters.data(), q, &at);
    return at;
}

RayStart Space::start(const StartPosition& at, const std::array<double, 3>& d) const {
    RayStart start{};
    module->start_from(hamiltonian, parameters.data(), &at, d.data(), &start);
    return start;
}

}  // namespace kagero
