#include "film/codec.h"

#include "error.h"
#include "film/partial_file.h"
#include "modules/module_files.h"

#include <filesystem>
#include <ostream>

namespace kagero {

const Codec& codec() {
    static const Codec& loaded = []() -> const Codec& {
        const std::string path = module_file("kagero-images.so");
        if (path.empty())
            throw RunError(
                "the image module kagero-images.so was not found in lib/kagero beside the program; build or install "
                "kagero again");
        const Codec* module = reinterpret_cast<CodecFunction>(open_module(path, "kagero_codec"))();
        if (module->abi != codec_abi)
            throw RunError(path + " belongs to another version of kagero; build or install kagero again");
        return *module;
    }();
    return loaded;
}

void write_picture(const std::string& path, const PictureToEncode& picture) {
    std::vector<unsigned char> file;
    const std::string reason = codec().encode(std::filesystem::path(path).extension().string(), picture, file);
    if (!reason.empty()) throw RunError("cannot write '" + path + "': " + reason);
    write_file(path, [&](std::ostream& out) {
        out.write(reinterpret_cast<const char*>(file.data()), static_cast<std::streamsize>(file.size()));
    });
}

}  // namespace kagero
