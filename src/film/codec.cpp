#include "film/codec.h"

#include "error.h"
#include "film/partial_file.h"
#include "modules/module_files.h"

#include <filesystem>
#include <mutex>
#include <ostream>

namespace kagero {
namespace {

/// Loads a module and returns what its function `entry` returns. Throws RunError if it belongs to another version.
template <class Function>
auto functions_of(const std::string& path, const char* entry) {
    const auto* functions = reinterpret_cast<Function>(open_module(path, entry))();
    if (functions->abi != codec_abi)
        throw RunError(path + " belongs to another version of kagero; build or install kagero again");
    return functions;
}

/// A format that a module of its own encodes.
struct EncodedFormat {
    const char* extension;
    const char* module;
    std::once_flag is_searched{};
    const Encoder* encoder = nullptr;  ///< Null if the module is not installed.
};
EncodedFormat formats[] = {{".exr", "kagero-openexr.so"}, {".png", "kagero-png.so"}};

/// Returns the encoder of a format; null if OpenImageIO encodes it.
const Encoder* encoder_of(std::string extension) {
    for (char& c : extension)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    for (EncodedFormat& format : formats) {
        if (extension != format.extension) continue;
        std::call_once(format.is_searched, [&] {
            const std::string path = module_file(format.module);
            if (!path.empty()) format.encoder = functions_of<EncoderFunction>(path, "kagero_encoder");
        });
        return format.encoder;
    }
    return nullptr;
}

}  // namespace

const Codec& codec() {
    static const Codec& loaded = []() -> const Codec& {
        const std::string path = module_file("kagero-images.so");
        if (path.empty())
            throw RunError(
                "the image module kagero-images.so was not found in lib/kagero beside the program; build or install "
                "kagero again");
        return *functions_of<CodecFunction>(path, "kagero_codec");
    }();
    return loaded;
}

void load_encoder(const std::string& extension) {
    if (!encoder_of(extension)) codec();
}

std::string encode_picture(const std::string& extension, const PictureToEncode& picture,
                           std::vector<unsigned char>& file) {
    const Encoder* const encoder = encoder_of(extension);
    return (encoder ? encoder->encode : codec().encode)(extension, picture, file);
}

void write_picture(const std::string& path, const PictureToEncode& picture) {
    std::vector<unsigned char> file;
    const std::string reason = encode_picture(std::filesystem::path(path).extension().string(), picture, file);
    if (!reason.empty()) throw RunError("cannot write '" + path + "': " + reason);
    write_file(path, [&](std::ostream& out) {
        out.write(reinterpret_cast<const char*>(file.data()), static_cast<std::streamsize>(file.size()));
    });
}

}  // namespace kagero
