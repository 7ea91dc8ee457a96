#include "geometry/gltf_check.h"

#include "error.h"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

namespace kagero {

namespace {

using nlohmann::json;

constexpr int deepest = 1000;

[[noreturn]] void refuse(const std::string& path, const std::string& message) {
    throw InputError({path, 0, 0}, "glTF: " + message);
}

std::uint32_t little_endian(const std::string& bytes, std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 4; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
    return value;
}

/// The JSON of a file. A binary one holds it as its first chunk, after "glTF", version, length, and the chunk's length
/// and kind.
std::string json_text(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::string text{std::istreambuf_iterator<char>(file), {}};
    if (!text.starts_with("glTF")) return text;
    constexpr std::size_t head = 20;
    if (text.size() < head) refuse(path, "the file ends inside its head");
    const std::uint32_t length = little_endian(text, 12);
    if (length > text.size() - head) refuse(path, "the file ends inside its JSON");
    text = text.substr(head, length);
    text.erase(text.find_last_not_of('\0') + 1);  // some writers fill up with these
    return text;
}

json parsed(const std::string& path, const std::string& text) {
    return json::parse(text, [&](int depth, json::parse_event_t, const json&) {
        if (depth > deepest) refuse(path, "brackets nested deeper than " + std::to_string(deepest));
        return true;
    });
}

/// Nodes are named by their place in an array, or in version 1 by keys of an object. Each is a child of one other at
/// most, so that there is one way up from each, and it is short.
void check_nodes(const std::string& path, const json& nodes) {
    std::map<std::string, std::string> parents;
    for (const auto& [name, node] : nodes.items()) {
        for (const json& child : node.value("children", json::array())) {
            const std::string text = child.is_string() ? child.get<std::string>() : child.dump();
            if (!parents.emplace(text, name).second) refuse(path, "node " + text + " is a child of two nodes");
        }
    }
    for (const auto& [name, node] : nodes.items()) {
        int depth = 0;
        for (auto above = parents.find(name); above != parents.end(); above = parents.find(above->second))
            if (++depth > deepest)
                refuse(path,
                       "node " + name + " lies more than " + std::to_string(deepest) + " nodes deep, or within itself");
    }
}

}  // namespace

bool is_gltf(const std::string& path) {
    std::string extension = std::filesystem::path(path).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    return extension == ".gltf" || extension == ".glb";
}

void check_gltf(const std::string& path) {
    try {
        const json file = parsed(path, json_text(path));
        check_nodes(path, file.value("nodes", json::array()));
    } catch (const json::exception& error) {
        const std::string reason = error.what();  // after the exception's own name, in brackets
        refuse(path, reason.substr(reason.find("] ") + 2));
    }
}

}  // namespace kagero
