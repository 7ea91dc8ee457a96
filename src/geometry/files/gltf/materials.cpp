#include "geometry/files/gltf/materials.h"

#include <algorithm>

namespace kagero {

namespace {

using nlohmann::json;

/// A material that is being read. Functions that refuse it name it.
struct MaterialReader {
    const GltfDocument& document;
    GltfBuffers& buffers;
    std::string name;  ///< Such as materials[0] "Wood".
    FileMaterial material{};
    std::string first_texture{};  ///< Name of the first texture; its coordinates are those of all.

    [[noreturn]] void refuse(const std::string& reason) const { refuse_gltf(document.source, name + ": " + reason); }
    const json* find(const json& object, const char* key) const { return find_member(document, object, key, name); }
    /// Returns numbers in a range, or `missing` if the key is missing.
    std::vector<double> numbers(const json& object, const char* key, const std::vector<double>& missing,
                                double greatest) const;
    double number(const json& object, const char* key, double missing, double greatest) const;
    /// Returns the texture of a key and notes its texture coordinates; nothing if the key is missing.
    std::optional<FileTexture> texture(const json& object, const char* key);
    void set_coordinates(const json& info, const char* key);
    BeyondEdge wrap(const json* sampler, const char* key, const std::string& where) const;
    void set_image(std::uint64_t index, FileTexture& texture);
};

std::vector<double> MaterialReader::numbers(const json& object, const char* key, const std::vector<double>& missing,
                                            double greatest) const {
    const json* member = find(object, key);
    if (!member) return missing;
    std::vector<double> values = numbers_of(document, *member, missing.size(), name + '.' + key);
    for (const double value : values)
        if (!(value >= 0 && value <= greatest))
            refuse(std::string(key) + " has the value " + number_text(value) +
                   "; the legal range is 0 <= value <= " + number_text(greatest));
    return values;
}

double MaterialReader::number(const json& object, const char* key, double missing, double greatest) const {
    const json* member = find(object, key);
    if (!member) return missing;
    const double value = member->is_number() ? member->get<double>() : -1;
    if (!(value >= 0 && value <= greatest))
        refuse(std::string(key) + " = " + text_of(*member) +
               " is not legal; the legal range is 0 <= value <= " + number_text(greatest));
    return value;
}

BeyondEdge MaterialReader::wrap(const json* sampler, const char* key, const std::string& where) const {
    const std::uint64_t code = sampler ? whole_number(document, *sampler, key, where, 10497) : 10497;
    if (code == 10497) return BeyondEdge::repeat;
    if (code == 33071) return BeyondEdge::clamp;
    if (code != 33648)
        refuse(where + '.' + key + " = " + std::to_string(code) + " is not legal; legal are 10497, 33071 and 33648");
    return BeyondEdge::mirror;
}

void MaterialReader::set_image(std::uint64_t index, FileTexture& texture) {
    const std::string where = "images[" + std::to_string(index) + "]";
    const json& image = entry_of(document, "images", index);
    const json *uri = find_member(document, image, "uri", where),
               *view = find_member(document, image, "bufferView", where);
    texture.path = document.source.path + "#" + where;
    if (view) {
        const std::uint64_t view_index = index_of(document, *view, "bufferViews", where + ".bufferView");
        texture.bytes = std::make_shared<const std::string>(buffers.view(view_index).bytes);
        return;
    }
    if (!uri || !uri->is_string()) refuse(where + " has neither a uri nor a bufferView; one of them is required");
    const std::string text = uri->get<std::string>();
    if (text.starts_with("data:"))
        texture.bytes = std::make_shared<const std::string>(embedded_bytes(document, text, where));
    else texture.path = path_of_gltf_uri(document.source.path, text);
}

void MaterialReader::set_coordinates(const json& info, const char* key) {
    std::uint64_t set = whole_number(document, info, "texCoord", name + '.' + key, 0);
    UvTransform transform;
    const json* extensions = find(info, "extensions");
    if (const json* stated = extensions ? find(*extensions, "KHR_texture_transform") : nullptr) {
        const auto pair = [&](const char* part, std::array<double, 2> missing) {
            const json* member = find(*stated, part);
            if (!member) return missing;
            const std::vector<double> found = numbers_of(document, *member, 2, name + '.' + key + '.' + part);
            return std::array{found[0], found[1]};
        };
        const json* rotation = find(*stated, "rotation");
        if (rotation && !rotation->is_number()) refuse(std::string(key) + ": rotation must be a number");
        transform = {pair("offset", {0, 0}), pair("scale", {1, 1}), rotation ? rotation->get<double>() : 0};
        set = whole_number(document, *stated, "texCoord", name + '.' + key, set);
    }
    if (first_texture.empty()) {
        first_texture = key;
        material.uv_set = set;
        material.uv_transform = transform;
    } else if (set != material.uv_set || transform != material.uv_transform) {
        refuse(std::string(key) + " and " + first_texture +
               " use different texture coordinates, which is not supported; give both the same texCoord and transform");
    }
}

std::optional<FileTexture> MaterialReader::texture(const json& object, const char* key) {
    const json* info = find(object, key);
    if (!info) return {};
    const json* index = find(*info, "index");
    if (!index) refuse(std::string(key) + " has no index, which is required");
    const std::uint64_t texture_index = index_of(document, *index, "textures", name + '.' + key);
    const std::string where = "textures[" + std::to_string(texture_index) + "]";
    const json& entry = entry_of(document, "textures", texture_index);
    const json* source = find_member(document, entry, "source", where);
    if (!source)
        refuse(std::string(key) + " is " + where +
               ", which has no source; an extension that stores its image elsewhere is not supported");
    set_coordinates(*info, key);
    FileTexture result;
    const json *stated = find_member(document, entry, "sampler", where), *sampler = nullptr;
    std::string sampler_name;
    if (stated) {
        const std::uint64_t i = index_of(document, *stated, "samplers", where + ".sampler");
        sampler_name = "samplers[" + std::to_string(i) + "]";
        sampler = &entry_of(document, "samplers", i);
    }
    result.along_u = wrap(sampler, "wrapS", sampler_name);
    result.along_v = wrap(sampler, "wrapT", sampler_name);
    set_image(index_of(document, *source, "images", where + ".source"), result);
    return result;
}

Double3 rgb_of(const std::vector<double>& numbers) { return {numbers[0], numbers[1], numbers[2]}; }

/// Reads the base colour and the metallic share; of the older extension, the diffuse colour.
void read_base(MaterialReader& reader, const json& entry, const json& extensions) {
    FileMaterial& material = reader.material;
    const json *base = reader.find(entry, "pbrMetallicRoughness"),
               *glossy = reader.find(extensions, "KHR_materials_pbrSpecularGlossiness");
    const json empty = json::object();
    if (glossy) {
        material.color = rgb_of(reader.numbers(*glossy, "diffuseFactor", {1, 1, 1, 1}, 1));
        material.color_texture = reader.texture(*glossy, "diffuseTexture");
        material.unused.push_back("the specular colour and the glossiness");
        return;
    }
    if (!base) base = &empty;
    material.color = rgb_of(reader.numbers(*base, "baseColorFactor", {1, 1, 1, 1}, 1));
    material.color_texture = reader.texture(*base, "baseColorTexture");
    if (material.is_unlit) return;
    material.metallic = reader.number(*base, "metallicFactor", 1, 1);
    if (reader.number(*base, "roughnessFactor", 1, 1) > 0) material.unused.push_back("roughness");
    if (!reader.find(*base, "metallicRoughnessTexture") || !(material.metallic > 0)) return;
    MaterialReader texture_reader = reader;  // its coordinates do not matter, because its mean is used
    texture_reader.first_texture.clear();
    material.metallic_texture = texture_reader.texture(*base, "metallicRoughnessTexture");
}

void read_emission(MaterialReader& reader, const json& entry, const json& extensions) {
    constexpr double greatest_strength = 1e6;
    FileMaterial& material = reader.material;
    const json* strength = reader.find(extensions, "KHR_materials_emissive_strength");
    const double factor = strength ? reader.number(*strength, "emissiveStrength", 1, greatest_strength) : 1;
    material.emission = rgb_of(reader.numbers(entry, "emissiveFactor", {0, 0, 0}, 1));
    for (double& channel : material.emission) channel *= factor;
    const bool emits = std::ranges::max(material.emission) > 0;
    if (emits) material.emission_texture = reader.texture(entry, "emissiveTexture");
}

void note_unused(MaterialReader& reader, const json& entry, const json& extensions) {
    std::vector<std::string>& unused = reader.material.unused;
    for (const char* key : {"normalTexture", "occlusionTexture"})
        if (reader.find(entry, key)) unused.emplace_back(key);
    const json* mode = reader.find(entry, "alphaMode");
    if (mode && *mode != "OPAQUE") unused.push_back("alphaMode = " + text_of(*mode));
    for (const auto& [name, value] : extensions.items())
        if (std::ranges::count(gltf_extensions(), name) == 0) unused.push_back("the extension " + name);
}

}  // namespace

FileMaterial default_gltf_material() {
    FileMaterial material;
    material.name = "the default material";
    material.color = {1, 1, 1};
    material.metallic = 1;
    material.unused = {"roughness"};
    return material;
}

FileMaterial read_gltf_material(const GltfDocument& document, GltfBuffers& buffers, std::uint64_t index) {
    const json& entry = entry_of(document, "materials", index);
    std::string name = "materials[" + std::to_string(index) + "]";
    const json* stated = find_member(document, entry, "name", name);
    if (stated && stated->is_string()) name += ' ' + text_of(*stated);
    MaterialReader reader{document, buffers, name};
    reader.material.name = name;
    static const json empty = json::object();
    const json* found = reader.find(entry, "extensions");
    const json& extensions = found ? *found : empty;
    if (!extensions.is_object()) reader.refuse("extensions must be an object");
    reader.material.is_unlit = extensions.contains("KHR_materials_unlit");
    read_base(reader, entry, extensions);
    if (!reader.material.is_unlit) read_emission(reader, entry, extensions);
    note_unused(reader, entry, extensions);
    return reader.material;
}

}  // namespace kagero
