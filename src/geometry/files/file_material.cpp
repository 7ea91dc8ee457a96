#include "geometry/files/file_material.h"

#include <cmath>

namespace kagero {

std::array<double, 2> UvTransform::operator()(const std::array<double, 2>& uv) const {
    const double u = scale[0] * uv[0], v = scale[1] * uv[1], c = std::cos(rotation), s = std::sin(rotation);
    return {c * u + s * v + offset[0], c * v - s * u + offset[1]};
}

std::vector<std::string> remarks_on_unused(const std::vector<FileMaterial>& materials) {
    constexpr std::size_t most_names = 4;
    std::map<std::string, std::vector<std::string>> users;
    for (const FileMaterial& material : materials)
        for (const std::string& property : material.unused) users[property].push_back(material.name);
    std::vector<std::string> remarks;
    for (const auto& [property, names] : users) {
        std::string list;
        for (std::size_t i = 0; i < std::min(names.size(), most_names); ++i) append_to_list(list, names[i]);
        if (names.size() > most_names) list += " and " + std::to_string(names.size() - most_names) + " more";
        remarks.push_back(property + " is not used; materials that state it: " + list);
    }
    return remarks;
}

}  // namespace kagero
