/// Support for tests of glTF files: a file in parts that a test can change, and its forms as text and as binary file.
#pragma once

#include "tests/support/mesh_file_fixture.h"

#include <functional>
#include <nlohmann/json.hpp>

namespace kagero::test {

using nlohmann::json;

inline std::string base64(const std::string& bytes) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const auto byte = [&](std::size_t k) { return k < bytes.size() ? static_cast<unsigned char>(bytes[k]) : 0u; };
        const unsigned bits = byte(i) << 16 | byte(i + 1) << 8 | byte(i + 2);
        text += digits[bits >> 18];
        text += digits[bits >> 12 & 63];
        text += i + 1 < bytes.size() ? digits[bits >> 6 & 63] : '=';
        text += i + 2 < bytes.size() ? digits[bits & 63] : '=';
    }
    return text;
}

/// A glTF file in parts: its JSON, and the bytes of its only buffer.
struct Parts {
    json file;
    std::string bytes;

    json& primitive() { return file["meshes"][0]["primitives"][0]; }
    json& accessor(int i) { return file["accessors"][i]; }
    /// Appends data and a view of it. Returns the index of the view.
    std::size_t add_view(const std::string& data) {
        file["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", data.size()}});
        bytes += data;
        return file["bufferViews"].size() - 1;
    }
    std::size_t add_accessor(const std::string& data, int component_type, int count, const char* type) {
        file["accessors"].push_back(
            {{"bufferView", add_view(data)}, {"componentType", component_type}, {"count", count}, {"type", type}});
        return file["accessors"].size() - 1;
    }
};

/// Returns a file with five vertices (accessor 0) and the indices of two triangles (accessor 1).
inline Parts two_triangles() {
    Parts parts;
    parts.file = {{"asset", {{"version", "2.0"}}},
                  {"scene", 0},
                  {"scenes", {{{"nodes", {0}}}}},
                  {"nodes", {{{"mesh", 0}}}},
                  {"meshes", {{{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"indices", 1}}}}}}},
                  {"accessors", json::array()},
                  {"bufferViews", json::array()}};
    parts.add_accessor(Bytes().add<float>({0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1, 0, 1, 5}).text, 5126, 5, "VEC3");
    parts.add_accessor(Bytes().add<std::uint16_t>({0, 1, 2, 0, 2, 3}).text, 5123, 6, "SCALAR");
    return parts;
}

inline const std::string two = "0 0 1, 1 0 1, 1 1 1 | 0 0 1, 1 1 1, 0 1 1";
inline const std::string one = "0 0 1, 1 0 1, 1 1 1";

/// Returns the file as text with its buffer embedded.
inline std::string embedded(Parts parts) {
    if (!parts.file.contains("buffers"))
        parts.file["buffers"] = {{{"byteLength", parts.bytes.size()},
                                  {"uri", "data:application/octet-stream;base64," + base64(parts.bytes)}}};
    return parts.file.dump();
}

inline std::string chunk(std::string data, std::uint32_t type, char padding) {
    while (data.size() % 4 != 0) data += padding;
    return Bytes().add<std::uint32_t>({static_cast<std::uint32_t>(data.size()), type}).text + data;
}

inline constexpr std::uint32_t json_type = 0x4e4f534a, binary_type = 0x004e4942;

/// Returns a binary file of some chunks.
inline std::string glb(const std::string& chunks) {
    return "glTF" + Bytes().add<std::uint32_t>({2, static_cast<std::uint32_t>(12 + chunks.size())}).text + chunks;
}

inline std::string binary(Parts parts, char padding = ' ') {
    parts.file["buffers"] = {{{"byteLength", parts.bytes.size()}}};
    return glb(chunk(parts.file.dump(), json_type, padding) + chunk(parts.bytes, binary_type, '\0'));
}

/// Fixture that loads changes of the file with two triangles.
class GltfFile : public MeshFileTest {
protected:
    /// A change of the file with two triangles, and what the result must give.
    struct Change {
        const char* name;
        std::function<void(Parts&)> apply;
        std::string triangles;
        std::string message;
    };
    template <std::size_t n>
    void expect_all(const Change (&changes)[n]) {
        for (const Change& change : changes) {
            Parts parts = two_triangles();
            change.apply(parts);
            expect({std::string(change.name) + ".gltf", embedded(parts), change.triangles, change.message});
        }
    }
};

}  // namespace kagero::test
