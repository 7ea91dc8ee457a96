#include "film/codec.h"

#include "error.h"
#include "film/partial_file.h"
#include "modules/places.h"

#include <filesystem>
#include <ostream>

namespace kagero {

const Codec& codec() {
    static const Codec& loaded = []() -> const Codec& {
        const std::string path = module_file("kagero-images.so");
        if (path.empty())
            throw RunError(
                "the module that reads and writes images, kagero-images.so, was not found beside the program "
                "(lib/kagero)");
        const Codec* offered = reinterpret_cast<KageroCodec>(open_module(path, "kagero_codec"))();
        if (offered->abi != codec_abi) throw RunError(path + " belongs to another version of kagero; build it anew");
        return *offered;
    }();
    return loaded;
}

void write_picture(const std::string& path, const PictureToEncode& picture) {
    std::vector<unsigned char> file;
    const std::string why = codec().encode(std::filesystem::path(path).extension().string(), picture, file);
    if (!why.empty()) throw RunError("cannot write '" + path + "': " + why);
    write_file(path, [&](std::ostream& out) {
        out.write(reinterpret_cast<const char*>(file.data()), static_cast<std::streamsize>(file.size()));
    });
}

}  // namespace kagero
