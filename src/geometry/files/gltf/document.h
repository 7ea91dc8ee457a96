/// The JSON of glTF files, and functions that read its values and check them.
#pragma once

#include "geometry/files/mesh_file.h"

#include <nlohmann/json.hpp>

namespace kagero {

/// A glTF file: its JSON, and the chunk of binary data that a .glb file can contain.
struct GltfDocument {
    const MeshSource& source;
    nlohmann::json json;
    std::string_view binary_chunk;
    bool has_binary_chunk = false;
};

[[noreturn]] void refuse_gltf(const MeshSource& source, const std::string& reason);

/// Returns a value for messages: in quotation marks, and cut if it is long.
std::string text_of(const nlohmann::json& value);

/// Reads the JSON of a file, and checks the version and the required extensions. Throws InputError if the file is not
/// JSON, if its brackets or nodes are nested deeper than 1000, if its nodes do not form trees, or if it has no scene.
GltfDocument parse_gltf(const MeshSource& source);

/// Returns the names of the extensions that files may require.
const std::vector<std::string>& gltf_extensions();

/// Returns true if an extension is in the list of the extensions that the file uses or requires.
bool uses_extension(const GltfDocument& document, const std::string& name);

/// Returns the member of an object; nullptr if it is missing. `where` is the position of the object in the file, for
/// messages.
const nlohmann::json* find_member(const GltfDocument& document, const nlohmann::json& object, const char* key,
                                  const std::string& where);

/// Returns the member of an object that must be an array; an empty array if it is missing.
const nlohmann::json& array_member(const GltfDocument& document, const nlohmann::json& object, const char* key,
                                   const std::string& where);

/// Returns a member that must be a whole number from 0 to 2^53; `missing` if there is none. A required member has the
/// value `no_default` for `missing`.
constexpr std::uint64_t no_default = ~std::uint64_t{0};
std::uint64_t whole_number(const GltfDocument& document, const nlohmann::json& object, const char* key,
                           const std::string& where, std::uint64_t missing);

/// Returns the value as an index of an array of the file, such as "accessors". `name` is the position of the value.
std::uint64_t index_of(const GltfDocument& document, const nlohmann::json& value, const char* array,
                       const std::string& name);

/// Returns `count` numbers of an array of that length.
std::vector<double> numbers_of(const GltfDocument& document, const nlohmann::json& array, std::size_t count,
                               const std::string& name);

/// Returns an entry of an array of the file, such as "accessors", which must exist and be an object.
const nlohmann::json& entry_of(const GltfDocument& document, const char* array, std::uint64_t index);

}  // namespace kagero
