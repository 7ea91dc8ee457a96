#include "parts/identity.h"

#include "error.h"
#include "geometry/mesh_files.h"
#include "parts/bytes.h"
#include "plan/names.h"
#include "scene/files.h"

#include <algorithm>
#include <fstream>

namespace kagero {
namespace {

/// Adds the contents of the files that the scene names, and of the files that these name.
void add_files(const SceneDescription& scene, Properties& identity) {
    for (const auto& [use, path] : files_of(scene)) {
        if (path.empty() || path == scene.path) continue;
        identity.emplace_back("the content of " + use, content_of_file(path));
        const std::vector<std::string> others = files_of_mesh(path);
        for (std::size_t i = 0; i < others.size(); ++i)
            identity.emplace_back("the content of file " + std::to_string(i + 1) + " of " + use,
                                  content_of_file(others[i]));
    }
}

std::string joined(const std::vector<std::string>& texts, const char* separator) {
    std::string all;
    for (const std::string& text : texts) all += (all.empty() ? "" : separator) + text;
    return all;
}

/// Returns the number of the first line in which two texts differ, from 1.
std::size_t first_different_line(const std::string& a, const std::string& b) {
    const std::size_t common = std::min(a.size(), b.size());
    const auto differing = std::mismatch(a.begin(), a.begin() + static_cast<std::ptrdiff_t>(common), b.begin()).first;
    return 1 + static_cast<std::size_t>(std::count(a.begin(), differing, '\n'));
}

/// Returns true if a message can contain the whole value.
bool is_short(const std::string& value) {
    constexpr std::size_t longest = 120;
    return value.size() <= longest && value.find('\n') == std::string::npos;
}

std::string shown(const std::string& value) { return value.empty() ? "empty" : value; }

const std::string* find_value(const Properties& properties, const std::string& name) {
    const auto found = std::find_if(properties.begin(), properties.end(),
                                    [&](const auto& property) { return property.first == name; });
    return found == properties.end() ? nullptr : &found->second;
}

}  // namespace

std::string content_of_file(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    std::uint64_t size = 0, hash = 0;
    std::string block(std::size_t{1} << 20, '\0');
    while (in.read(block.data(), static_cast<std::streamsize>(block.size())) || in.gcount() > 0) {
        const auto count = static_cast<std::size_t>(in.gcount());
        hash = checksum({block.data(), count}, hash);
        size += count;
    }
    if (!in.eof()) throw InputError("the file " + path + " cannot be read");
    constexpr char digits[] = "0123456789abcdef";
    std::string text = std::to_string(size) + " bytes with the hash ";
    for (int shift = 60; shift >= 0; shift -= 4) text += digits[hash >> shift & 15];
    return text;
}

Properties identity_of(const Plan& plan, const Options& options) {
    const SceneDescription& scene = plan.description();
    const Tile& window = plan.view.window;
    const std::string unspecified = "auto";
    Properties identity{
        {"the version of kagero", KAGERO_VERSION},
        {"the compiler", plan.module().compiler},
        {"the instruction set", plan.module().isa},
        {"the scene", scene.text},
        {"the list of overrides", joined(scene.overrides, ", ")},
        {"--strategy", options.strategy ? name_of(*options.strategy) : unspecified},
        {"--precision", options.precision ? name_of(*options.precision) : unspecified},
        {"the shape of tiles", options.schedule == Schedule::scanline ? "rows" : "squares"},
        {"the size of the film", std::to_string(scene.film.width) + "x" + std::to_string(scene.film.height)},
        {"the rendered window", std::to_string(window.x0) + "," + std::to_string(window.y0) + "," +
                                    std::to_string(window.x1) + "," + std::to_string(window.y1)},
        {"the list of layers", joined(scene.film.layers, ",")},
        {"the measurement of the error of H, which --json and .exr need,", options.energy_error ? "on" : "off"},
    };
    add_files(scene, identity);
    return identity;
}

std::string describe_difference(const Properties& first, const std::string& first_name, const Properties& second,
                                const std::string& second_name) {
    for (const auto& [name, value] : first) {
        const std::string* other = find_value(second, name);
        if (!other) return name + " is stated in " + first_name + ", but not in " + second_name;
        if (*other == value) continue;
        if (is_short(value) && is_short(*other))
            return name + " is " + shown(value) + " in " + first_name + ", but " + shown(*other) + " in " + second_name;
        return name + " differs between " + first_name + " and " + second_name + ", first in line " +
               std::to_string(first_different_line(value, *other));
    }
    for (const auto& [name, value] : second)
        if (!find_value(first, name)) return name + " is stated in " + second_name + ", but not in " + first_name;
    return "";
}

}  // namespace kagero
