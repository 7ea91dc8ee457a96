#include "geometry/files/gltf/document.h"

#include <algorithm>
#include <map>

namespace kagero {

namespace {

using nlohmann::json;

constexpr int max_depth = 1000;

std::uint32_t little_endian(std::string_view bytes, std::size_t offset) {
    std::uint32_t value = 0;
    for (std::size_t i = 4; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[offset + i]);
    return value;
}

/// Divides a binary file into its chunks. The file begins with "glTF", the version and the file's length. A chunk
/// begins with its length and its type. Returns the text of the first chunk, which must be JSON.
std::string_view read_chunks(GltfDocument& document) {
    constexpr std::uint32_t json_type = 0x4e4f534a, binary_type = 0x004e4942;
    constexpr std::size_t file_header = 12, chunk_header = 8;
    const MeshSource& source = document.source;
    std::string_view rest = source.bytes;
    if (rest.size() < file_header + chunk_header)
        refuse_gltf(source, "the file ends inside its header of 20 bytes; it is truncated");
    if (little_endian(rest, 4) != 2)
        refuse_gltf(source, "the file has version " + std::to_string(little_endian(rest, 4)) +
                                " of the binary format; the legal version is 2");
    if (little_endian(rest, 8) > rest.size())
        refuse_gltf(source, "the file has " + std::to_string(rest.size()) + " bytes, but its header declares " +
                                std::to_string(little_endian(rest, 8)) + "; it is truncated");
    rest = rest.substr(0, little_endian(rest, 8));
    rest.remove_prefix(std::min(file_header, rest.size()));
    std::string_view text;
    for (bool is_first = true; rest.size() >= chunk_header; is_first = false) {
        const std::uint32_t length = little_endian(rest, 0), type = little_endian(rest, 4);
        rest.remove_prefix(chunk_header);
        if (length > rest.size())
            refuse_gltf(source, std::string("the file ends inside its ") + (is_first ? "JSON" : "binary") +
                                    " chunk; it is truncated");
        if (is_first != (type == json_type)) refuse_gltf(source, "the JSON chunk must be the first and only one");
        if (is_first) {
            text = rest.substr(0, length);
        } else if (type == binary_type && !document.has_binary_chunk) {
            document.binary_chunk = rest.substr(0, length);
            document.has_binary_chunk = true;
        }
        rest.remove_prefix(length);
    }
    return text.substr(0, text.find_last_not_of('\0') + 1);  // some writers pad the chunk with zeros
}

json parse_json(const MeshSource& source, std::string_view text) {
    return json::parse(text, [&](int depth, json::parse_event_t, const json&) {
        if (depth > max_depth)
            refuse_gltf(source, "brackets are nested deeper than the limit of " + std::to_string(max_depth));
        return true;
    });
}

/// Checks that every node has at most one parent and at most 1000 ancestors, so that the nodes form trees. Nodes are
/// identified by their index in an array, or in version 1 of glTF by the keys of an object.
void check_nodes(const MeshSource& source, const json& nodes) {
    std::map<std::string, std::string> parents;  // the parent of each child
    for (const auto& [name, node] : nodes.items()) {
        for (const json& child : node.value("children", json::array())) {
            const std::string text = child.is_string()   ? child.get<std::string>()
                                     : child.is_number() ? number_text(child.get<double>())
                                                         : child.dump();
            if (!parents.emplace(text, name).second)
                refuse_gltf(source, "node " + text + " is a child of two nodes; a node may have only one parent");
        }
    }
    std::map<std::string, int> depths;  // the number of ancestors of nodes that have been checked
    for (const auto& [name, node] : nodes.items()) {
        std::vector<std::string> path{name};  // the node and its ancestors that have not been checked
        while (!depths.contains(path.back()) && parents.contains(path.back()) && path.size() <= max_depth + 1)
            path.push_back(parents.at(path.back()));
        const auto known = depths.find(path.back());
        int depth = known == depths.end() ? 0 : known->second;
        if (depth + static_cast<int>(path.size()) - 1 > max_depth)
            refuse_gltf(source, "node " + name + " is nested more than " + std::to_string(max_depth) +
                                    " nodes deep, or it belongs to a cycle of nodes");
        for (std::size_t i = path.size(); i-- > 0; ++depth) depths[path[i]] = depth;
    }
}

/// Refuses files that cannot be read as a whole: other versions, and extensions without which the file is wrong.
void check_header(const GltfDocument& document) {
    const json& file = document.json;
    if (!file.contains("scenes") || file["scenes"].empty())
        refuse_gltf(document.source, "the file cannot be read: it contains no scene; the key scenes must list one");
    const json* asset = find_member(document, file, "asset", "the file");
    const json* version = asset ? find_member(document, *asset, "version", "asset") : nullptr;
    if (!version || !version->is_string() || !version->get<std::string>().starts_with("2."))
        refuse_gltf(document.source, "asset.version = " + (version ? text_of(*version) : "\"\"") +
                                         " is not supported; the legal version is 2.0");
    std::string supported;
    for (const std::string& name : gltf_extensions()) append_to_list(supported, name);
    for (const json& name : array_member(document, file, "extensionsRequired", "the file"))
        if (!name.is_string() || std::ranges::count(gltf_extensions(), name.get<std::string>()) == 0)
            refuse_gltf(document.source, "the file requires the extension " + text_of(name) +
                                             ", which is not supported; supported are " + supported +
                                             ". Export the file without it");
}

}  // namespace

const std::vector<std::string>& gltf_extensions() {
    static const std::vector<std::string> extensions{"KHR_mesh_quantization", "KHR_texture_transform",
                                                     "KHR_materials_unlit", "KHR_materials_emissive_strength",
                                                     "KHR_materials_pbrSpecularGlossiness"};
    return extensions;
}

void refuse_gltf(const MeshSource& source, const std::string& reason) { refuse_file(source, 0, "glTF: " + reason); }

std::string text_of(const json& value) {
    return in_quotes(value.is_string() ? value.get_ref<const std::string&>() : value.dump());
}

GltfDocument parse_gltf(const MeshSource& source) {
    GltfDocument document{source, {}, {}};
    const bool is_binary = source.bytes.starts_with("glTF");
    document.json = parse_json(source, is_binary ? read_chunks(document) : std::string_view(source.bytes));
    if (!document.json.is_object()) refuse_gltf(source, "the file must contain a JSON object");
    check_nodes(source, document.json.value("nodes", json::array()));
    check_header(document);
    return document;
}

bool uses_extension(const GltfDocument& document, const std::string& name) {
    for (const char* key : {"extensionsUsed", "extensionsRequired"})
        for (const json& used : array_member(document, document.json, key, "the file"))
            if (used == name) return true;
    return false;
}

const json* find_member(const GltfDocument& document, const json& object, const char* key, const std::string& where) {
    if (!object.is_object()) refuse_gltf(document.source, where + " must be an object");
    const auto found = object.find(key);
    return found == object.end() ? nullptr : &*found;
}

const json& array_member(const GltfDocument& document, const json& object, const char* key, const std::string& where) {
    static const json empty = json::array();
    const json* member = find_member(document, object, key, where);
    if (member && !member->is_array()) refuse_gltf(document.source, where + '.' + key + " must be an array");
    return member ? *member : empty;
}

std::uint64_t whole_number(const GltfDocument& document, const json& object, const char* key, const std::string& where,
                           std::uint64_t missing) {
    constexpr double greatest = 9007199254740992;  // 2^53
    const json* member = find_member(document, object, key, where);
    if (!member && missing != no_default) return missing;
    if (!member) refuse_gltf(document.source, where + " has no " + key + ", which is required");
    const double number = member->is_number() ? member->get<double>() : -1;
    if (!(number >= 0 && number <= greatest && number == std::floor(number)))
        refuse_gltf(document.source,
                    where + '.' + key + " = " + text_of(*member) + " is not legal; it must be a whole number >= 0");
    return static_cast<std::uint64_t>(number);
}

std::uint64_t index_of(const GltfDocument& document, const json& value, const char* array, const std::string& name) {
    const std::size_t count = array_member(document, document.json, array, "the file").size();
    const double index = value.is_number() ? value.get<double>() : -1;
    if (!(index >= 0 && index < double(count) && index == std::floor(index)))
        refuse_gltf(document.source, name + " = " + text_of(value) + " is not an index of " + array +
                                         "; the file has " + std::to_string(count) + ", counted from 0");
    return static_cast<std::uint64_t>(index);
}

std::vector<double> numbers_of(const GltfDocument& document, const json& array, std::size_t count,
                               const std::string& name) {
    const bool is_legal = array.is_array() && array.size() == count &&
                          std::all_of(array.begin(), array.end(), [](const json& n) { return n.is_number(); });
    if (!is_legal) refuse_gltf(document.source, name + " must be an array of " + std::to_string(count) + " numbers");
    return array.get<std::vector<double>>();
}

const json& entry_of(const GltfDocument& document, const char* array, std::uint64_t index) {
    return array_member(document, document.json, array, "the file").at(index);
}

}  // namespace kagero
