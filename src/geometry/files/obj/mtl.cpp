#include "geometry/files/obj/mtl.h"

#include "geometry/files/obj/statements.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace kagero {

namespace {

/// Returns the path of a file that an OBJ or MTL file at `path` names. A backslash separates folders, like a slash.
std::string path_beside(const std::string& path, std::string name) {
    namespace fs = std::filesystem;
    const fs::path folder = fs::path(path).parent_path(), as_written = folder / name;
    std::error_code error;
    if (fs::is_regular_file(as_written, error)) return as_written.string();
    std::replace(name.begin(), name.end(), '\\', '/');
    return (folder / name).lexically_normal().string();
}

/// Statements without effect on the appearance as kagero computes it, with the names of the properties in remarks. An
/// empty name means that the statement is left out silently, because the properties that are used imply it.
const std::map<std::string, std::string> unused_statements{
    {"Ka", ""},           {"map_Ka", ""},       {"illum", ""},       {"sharpness", ""},
    {"Ks", "Ks"},         {"map_Ks", "map_Ks"}, {"Ns", "Ns"},        {"map_Ns", "map_Ns"},
    {"d", "d"},           {"Tr", "Tr"},         {"map_d", "map_d"},  {"map_Tr", "map_Tr"},
    {"Tf", "Tf"},         {"Ni", "Ni"},         {"Pr", "roughness"}, {"map_Pr", "roughness"},
    {"Ps", "sheen"},      {"map_Ps", "sheen"},  {"Pc", "clearcoat"}, {"Pcr", "clearcoat"},
    {"aniso", "aniso"},   {"anisor", "anisor"}, {"norm", "norm"},    {"bump", "bump"},
    {"map_bump", "bump"}, {"map_Bump", "bump"}, {"disp", "disp"},    {"decal", "decal"},
    {"refl", "refl"},     {"map_refl", "refl"}, {"map_aat", ""},     {"Km", ""}};

struct MtlReader {
    const MeshSource& source;
    MtlMaterials& materials;
    FileMaterial* current = nullptr;
    std::size_t line = 0;
    std::map<std::string, bool> has_color{};          ///< Materials that state Kd.
    std::map<std::string, UvTransform> transforms{};  ///< Transforms of the first texture of materials.

    [[noreturn]] void refuse(const std::string& reason) const {
        refuse_file(source, line, "MTL: " + (current ? current->name + ": " : "") + reason);
    }
};

/// Returns the only number of a statement, or its three numbers, of which the last two may be missing.
std::vector<double> numbers_in(const MtlReader& mtl, const ObjStatement& statement, std::size_t count,
                               double greatest) {
    const std::string keyword(statement.words[0]);
    const std::size_t given = statement.words.size() - 1;
    if (given > 0 && (statement.words[1] == "spectral" || statement.words[1] == "xyz"))
        mtl.refuse(keyword + " is stated by " + in_quotes(statement.words[1]) +
                   ", which is not supported; state red, green and blue");
    if (given != count && given != 1)
        mtl.refuse(keyword + " has " + std::to_string(given) + " numbers; it needs " + std::to_string(count));
    std::vector<double> numbers(count);
    for (std::size_t i = 0; i < count; ++i) {
        const std::string_view word = statement.words[given == 1 ? 1 : i + 1];
        if (!parse_number(word, numbers[i]) || !(numbers[i] >= 0 && numbers[i] <= greatest))
            mtl.refuse(keyword + " has the value " + in_quotes(word) +
                       "; the legal range is 0 <= value <= " + number_text(greatest));
    }
    return numbers;
}

Double3 color_in(const MtlReader& mtl, const ObjStatement& statement, double greatest) {
    const std::vector<double> numbers = numbers_in(mtl, statement, 3, greatest);
    return {numbers[0], numbers[1], numbers[2]};
}

/// Reads an option of a texture, which begins at words[i]. Returns the index of the word after it.
std::size_t read_option(const MtlReader& mtl, const std::vector<std::string_view>& words, std::size_t i,
                        UvTransform& transform, FileTexture& texture) {
    const std::string option(words[i]);
    const auto is_number = [&](std::size_t k, double& number) {
        return k < words.size() - 1 && parse_number(words[k], number);
    };
    double number = 0;
    if (option == "-s" || option == "-o") {
        std::array<double, 2>& pair = option == "-s" ? transform.scale : transform.offset;
        if (!is_number(++i, number)) mtl.refuse("the option " + option + " of a texture needs 1 to 3 numbers");
        for (std::size_t k = 0; k < 3 && is_number(i, number); ++k, ++i)
            if (k < 2) pair[k] = number;
        return i;
    }
    static const std::vector<std::string> with_word{"-clamp",  "-blendu",  "-blendv", "-cc",  "-boost",
                                                    "-texres", "-imfchan", "-bm",     "-type"};
    if (std::ranges::count(with_word, option) == 0 || i + 2 >= words.size())
        mtl.refuse("the option " + option + " of a texture is not supported; remove it");
    if (option == "-clamp" && words[i + 1] == "on") texture.along_u = texture.along_v = BeyondEdge::clamp;
    return i + 2;
}

FileTexture texture_in(MtlReader& mtl, const ObjStatement& statement) {
    const std::vector<std::string_view>& words = statement.words;
    FileTexture texture;
    UvTransform transform;
    std::size_t i = 1;
    while (i < words.size() && words[i].size() > 1 && words[i][0] == '-')
        i = read_option(mtl, words, i, transform, texture);
    if (i >= words.size()) mtl.refuse(std::string(words[0]) + " names no image; the name of a file is required");
    const char* begin = words[i].data();
    const char* end = words.back().data() + words.back().size();
    texture.path = path_beside(mtl.source.path, {begin, end});  // a name may contain spaces
    const auto [first, is_first] = mtl.transforms.emplace(mtl.current->name, transform);
    if (!is_first && first->second != transform)
        mtl.refuse("its textures use different values of -s or -o, which is not supported; use the same values");
    mtl.current->uv_transform = transform;
    return texture;
}

void begin_material(MtlReader& mtl, const ObjStatement& statement) {
    mtl.current = nullptr;
    if (statement.words.size() < 2) mtl.refuse("newmtl has no name; the name of a material is required");
    const std::string name = name_in(statement);
    FileMaterial& material = mtl.materials[name] = {};
    material.name = "material " + in_quotes(name);
    mtl.current = &material;
}

void read_property(MtlReader& mtl, const ObjStatement& statement) {
    constexpr double greatest_emission = 1e6;
    const std::string keyword(statement.words[0]);
    if (!mtl.current) mtl.refuse(in_quotes(keyword) + " stands before the first newmtl; begin with newmtl NAME");
    FileMaterial& material = *mtl.current;
    if (keyword == "Kd") {
        material.color = color_in(mtl, statement, 1);
        mtl.has_color[material.name] = true;
    } else if (keyword == "Ke") material.emission = color_in(mtl, statement, greatest_emission);
    else if (keyword == "Pm") material.metallic = numbers_in(mtl, statement, 1, 1)[0];
    else if (keyword == "map_Kd") material.color_texture = texture_in(mtl, statement);
    else if (keyword == "map_Ke") material.emission_texture = texture_in(mtl, statement);
    else if (keyword == "map_Pm") material.unused.emplace_back("map_Pm");
    else if (const auto found = unused_statements.find(keyword); found != unused_statements.end()) {
        if (!found->second.empty()) material.unused.push_back(found->second);
    } else material.unused.push_back("the statement " + in_quotes(keyword));
}

/// Completes the materials: a texture without a factor has the factor 1.
void complete(const MtlReader& mtl) {
    for (auto& [name, material] : mtl.materials) {
        if (material.color_texture && !mtl.has_color.contains(material.name)) material.color = {1, 1, 1};
        if (material.emission_texture && material.emission == Double3{}) material.emission = {1, 1, 1};
        std::sort(material.unused.begin(), material.unused.end());
        material.unused.erase(std::unique(material.unused.begin(), material.unused.end()), material.unused.end());
    }
}

/// Reads an MTL file. `used_by` is the statement of the OBJ file, for messages.
void read_mtl(const std::string& path, const std::string& used_by, MtlMaterials& materials) {
    MeshSource source{path, {}, used_by};
    std::error_code error;
    std::ifstream file;
    if (std::filesystem::is_regular_file(path, error)) file.open(path, std::ios::binary);
    if (!file.is_open()) refuse_file(source, 0, "MTL: the file cannot be read: it does not exist, or is no file");
    source.bytes.assign(std::istreambuf_iterator<char>(file), {});
    MtlMaterials read;
    MtlReader mtl{source, read};
    ObjStatements statements(source.bytes);
    for (ObjStatement statement; statements.next(statement);) {
        mtl.line = statement.line;
        if (statement.words[0] == "newmtl") begin_material(mtl, statement);
        else read_property(mtl, statement);
    }
    complete(mtl);
    for (auto& [name, material] : read) materials[name] = std::move(material);
}

}  // namespace

std::vector<std::string> read_libraries(const MeshSource& obj, MtlMaterials& materials) {
    std::vector<std::string> paths;
    ObjStatements statements(obj.bytes);
    for (ObjStatement statement; statements.next(statement);) {
        if (statement.words[0] != "mtllib") continue;
        // A statement names several files, or one whose name contains spaces.
        std::vector<std::string> names(statement.words.begin() + 1, statement.words.end());
        if (std::filesystem::is_regular_file(path_beside(obj.path, name_in(statement)))) names = {name_in(statement)};
        for (const std::string& name : names) {
            paths.push_back(path_beside(obj.path, name));
            read_mtl(paths.back(), obj.path + ":" + std::to_string(statement.line) + ", and that by " + obj.used_by,
                     materials);
        }
    }
    return paths;
}

}  // namespace kagero
