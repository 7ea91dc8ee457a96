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

constexpr int max_depth = 1000;

[[noreturn]] void refuse(const std::string& path, const std::string& message) {
    throw InputError({path, 0, 0}, "glTF: " + message);
}

std::uint32_t little_endian(const std::string& bytes, std::size_t offset) {
    std::uint32_t value = 0;
    for (std::size_t i = 4; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[offset + i]);
    return value;
}

/// Returns the JSON text of a file. In a binary file, this text is the first chunk. The 20 bytes before the text
/// contain "glTF", the version, the file's length, and the length and type of the chunk.
std::string json_text(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::string text{std::istreambuf_iterator<char>(file), {}};
    if (!text.starts_with("glTF")) return text;
    constexpr std::size_t header_size = 20;
    if (text.size() < header_size) refuse(path, "the file ends inside its header of 20 bytes; it is truncated");
    const std::uint32_t length = little_endian(text, 12);
    if (length > text.size() - header_size) refuse(path, "the file ends inside its JSON chunk; it is truncated");
    text = text.substr(header_size, length);
    text.erase(text.find_last_not_of('\0') + 1);  // some writers pad the chunk with zeros
    return text;
}

json parse_json(const std::string& path, const std::string& text) {
    return json::parse(text, [&](int depth, json::parse_event_t, const json&) {
        if (depth > max_depth)
            refuse(path, "brackets are nested deeper than the limit of " + std::to_string(max_depth));
        return true;
    });
}

/// Checks that every node has at most one parent and at most 1000 ancestors, so that the nodes form trees. Nodes are
/// identified by their index in an array, or in version 1 of glTF by the keys of an object.
void check_nodes(const std::string& path, const json& nodes) {
    std::map<std::string, std::string> parents;  // the parent of each child
    for (const auto& [name, node] : nodes.items()) {
        for (const json& child : node.value("children", json::array())) {
            const std::string text = child.is_string() ? child.get<std::string>() : child.dump();
            if (!parents.emplace(text, name).second)
                refuse(path, "node " + text + " is a child of two nodes; a node may have only one parent");
        }
    }
    for (const auto& [name, node] : nodes.items()) {
        int depth = 0;
        for (auto parent = parents.find(name); parent != parents.end(); parent = parents.find(parent->second))
            if (++depth > max_depth)
                refuse(path, "node " + name + " is nested more than " + std::to_string(max_depth) +
                                 " nodes deep, or it belongs to a cycle of nodes");
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
        const json file = parse_json(path, json_text(path));
        check_nodes(path, file.value("nodes", json::array()));
    } catch (const json::exception& error) {
        const std::string reason = error.what();  // the reason follows the exception's name, which is in brackets
        refuse(path, reason.substr(reason.find("] ") + 2));
    }
}

}  // namespace kagero
