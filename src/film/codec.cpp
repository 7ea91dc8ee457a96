#include "film/codec.h"

#include "error.h"
#include "film/partial_file.h"
#include "modules/module_files.h"

#include <filesystem>
#include <ostream>

namespace kagero {
namespace {

/// A format that a module of its own encodes.
struct EncodedFormat {
    const char* extension;
    const char* module;
};
constexpr EncodedFormat formats[] = {{".exr", "kagero-openexr.so"}, {".png", "kagero-png.so"}};

/// Loads a module and returns what its function `entry` returns. Throws RunError if it belongs to another version.
template <class Function>
auto functions_of(const std::string& path, const char* entry) {
    const auto* functions = reinterpret_cast<Function>(open_module(path, entry))();
    if (functions->abi != codec_abi)
        throw RunError(path + " belongs to another version of kagero; build or install kagero again");
    return functions;
}

/// Returns the encoder at an index of `formats`; null if its module is not installed.
template <std::size_t Index>
const Encoder* encoder_at() {
    static const Encoder* const encoder = []() -> const Encoder* {
        const std::string path = module_file(formats[Index].module);
        return path.empty() ? nullptr : functions_of<EncoderFunction>(path, "kagero_encoder");
    }();
    return encoder;
}

/// Returns the encoder of a format; null if OpenImageIO encodes it.
template <std::size_t... Index>
const Encoder* encoder_of(std::string extension, std::index_sequence<Index...>) {
    for (char& c : extension)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    const Encoder* encoder = nullptr;
    ((extension == formats[Index].extension && (encoder = encoder_at<Index>())), ...);
    return encoder;
}
const Encoder* encoder_of(const std::string& extension) {
    return encoder_of(extension, std::make_index_sequence<std::size(formats)>());
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
