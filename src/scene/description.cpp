#include "scene/description.h"

namespace kagero {

const std::vector<std::string>& refill_names() {
    static const std::vector<std::string> names{"auto", "on", "off"};
    return names;
}

const std::vector<std::string>& observer_names() {
    static const std::vector<std::string> names{"static", "zamo", "falling", "coordinate"};
    return names;
}

const std::vector<std::string>& camera_type_names() {
    static const std::vector<std::string> names{"perspective", "equirectangular", "orthographic"};
    return names;
}

const std::vector<std::string>& shape_names() {
    static const std::vector<std::string> names{"rectangle", "box", "room", "sphere", "mesh", "disk"};
    return names;
}

const std::vector<std::string>& face_names() {
    static const std::vector<std::string> names{"px", "nx", "py", "ny", "pz", "nz"};
    return names;
}

const HamiltonianInfo* Catalogue::hamiltonian_named(const std::string& name) const {
    for (std::uint32_t i = 0; i < hamiltonian_count; ++i)
        if (name == hamiltonians[i].name) return &hamiltonians[i];
    return nullptr;
}

}  // namespace kagero
