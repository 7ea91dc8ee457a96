// Writes the textures of the example scenes, which are computed from formulas and fixed seeds. Every run gives the same
// pictures.
//
//     kagero-textures [DIRECTORY [NAME ...]]        default: all textures, to the working directory
#include "textures.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <span>

namespace {

// A new texture needs one more row.
constexpr struct {
    const char* name;
    textures::Picture (*make)();
    int quality;
} pictures[] = {
    {"galaxy-sky.jpg", textures::galaxy_sky, 90},
    {"milkyway.jpg", textures::milky_way, 90},
    {"paving.jpg", textures::paving, 88},
    {"clouds.jpg", textures::clouds, 90},
};

}  // namespace

int main(int count, char** words) try {
    const std::string directory = count > 1 ? words[1] : ".";
    const std::span<char*> names(words + std::min(count, 2), words + count);
    for (const auto& picture : pictures) {
        const auto is_named = [&](const char* name) { return std::string(name) == picture.name; };
        if (!names.empty() && std::none_of(names.begin(), names.end(), is_named)) continue;
        textures::Picture made = picture.make();
        textures::write_jpeg(made, directory + "/" + picture.name, picture.quality);
        std::fprintf(stderr, "%s/%s: %d x %d\n", directory.c_str(), picture.name, made.width, made.height);
    }
} catch (const std::exception& error) {
    std::fprintf(stderr, "kagero-textures: %s\n", error.what());
    return 1;
}
