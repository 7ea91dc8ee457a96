#include "geometry/files/gltf/buffers.h"

#include <filesystem>
#include <fstream>
#include <iterator>

namespace kagero {

namespace {

using nlohmann::json;
namespace fs = std::filesystem;

/// Decodes base64. Returns false if the text contains other letters.
bool decode_base64(std::string_view text, std::string& bytes) {
    static constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    while (text.ends_with('=')) text.remove_suffix(1);
    bytes.reserve(text.size() / 4 * 3 + 3);
    std::uint32_t bits = 0, count = 0;
    for (const char letter : text) {
        const std::size_t digit = digits.find(letter);
        if (digit == std::string_view::npos) return false;
        bits = (bits << 6 | static_cast<std::uint32_t>(digit)) & 0xffffff;
        count += 6;
        if (count < 8) continue;
        count -= 8;
        bytes += static_cast<char>(bits >> count & 0xff);
    }
    return true;
}

/// Decodes letters that are written as % and two hexadecimal digits.
std::string decode_percent(const std::string& text) {
    static constexpr std::string_view digits = "0123456789abcdef";
    std::string decoded;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const auto digit = [&](std::size_t k) {
            return k < text.size() ? digits.find(static_cast<char>(std::tolower(static_cast<unsigned char>(text[k]))))
                                   : std::string_view::npos;
        };
        const std::size_t high = digit(i + 1), low = digit(i + 2);
        if (text[i] != '%' || high == std::string_view::npos || low == std::string_view::npos) {
            decoded += text[i];
            continue;
        }
        decoded += static_cast<char>(high * 16 + low);
        i += 2;
    }
    return decoded;
}

}  // namespace

std::string path_of_gltf_uri(const std::string& path, const std::string& uri) {
    const fs::path folder = fs::path(path).parent_path(), decoded = folder / decode_percent(uri);
    std::error_code error;
    return (fs::is_regular_file(decoded, error) ? decoded : folder / uri).string();  // some writers do not encode %
}

std::string embedded_bytes(const GltfDocument& document, const std::string& uri, const std::string& name) {
    std::string bytes;
    const std::size_t comma = uri.find(',');
    const bool is_base64 = comma != std::string::npos && uri.substr(0, comma).ends_with(";base64");
    if (!is_base64 || !decode_base64(std::string_view(uri).substr(comma + 1), bytes))
        refuse_gltf(document.source, name + ".uri is not legal; embedded data must be base64");
    return bytes;
}

std::string GltfBuffers::read_uri(const std::string& uri, const std::string& name) const {
    if (uri.starts_with("data:")) return embedded_bytes(document_, uri, name);
    if (uri.find("://") != std::string::npos)
        refuse_gltf(document_.source, name + ".uri = " + in_quotes(uri) + " is not the path of a file");
    const fs::path path = path_of_gltf_uri(document_.source.path, uri);
    std::error_code error;
    std::ifstream file;
    if (fs::is_regular_file(path, error)) file.open(path, std::ios::binary);
    if (!file.is_open())
        refuse_gltf(document_.source, name + ".uri = " + in_quotes(uri) + ": there is no file " + path.string());
    return {std::istreambuf_iterator<char>(file), {}};
}

std::string_view GltfBuffers::buffer(std::uint64_t index) {
    const auto found = buffers_.find(index);
    if (found != buffers_.end()) return found->second;
    const std::string name = "buffers[" + std::to_string(index) + "]";
    const json& buffer = entry_of(document_, "buffers", index);
    const std::uint64_t length = whole_number(document_, buffer, "byteLength", name, no_default);
    const json* uri = find_member(document_, buffer, "uri", name);
    std::string bytes;
    if (uri && uri->is_string()) {
        bytes = read_uri(uri->get<std::string>(), name);
    } else if (!uri && index == 0 && document_.has_binary_chunk) {
        bytes = document_.binary_chunk;
    } else {
        refuse_gltf(document_.source, name + " has no data: it has no uri, and the file has no binary chunk for it");
    }
    if (bytes.size() < length)
        refuse_gltf(document_.source, name + ".byteLength = " + std::to_string(length) + ", but there are only " +
                                          std::to_string(bytes.size()) + " bytes; the data is truncated");
    bytes.resize(length);
    return buffers_[index] = std::move(bytes);
}

GltfView GltfBuffers::view(std::uint64_t index) {
    const std::string name = "bufferViews[" + std::to_string(index) + "]";
    const json& view = entry_of(document_, "bufferViews", index);
    const json* buffer_index = find_member(document_, view, "buffer", name);
    if (!buffer_index) refuse_gltf(document_.source, name + " has no buffer, which is required");
    const std::string_view bytes = buffer(index_of(document_, *buffer_index, "buffers", name + ".buffer"));
    const std::uint64_t offset = whole_number(document_, view, "byteOffset", name, 0);
    const std::uint64_t length = whole_number(document_, view, "byteLength", name, no_default);
    if (offset > bytes.size() || length > bytes.size() - offset)
        refuse_gltf(document_.source, name + " contains the bytes from " + std::to_string(offset) + " to " +
                                          std::to_string(offset + length) + ", but its buffer has only " +
                                          std::to_string(bytes.size()));
    return {bytes.substr(offset, length), whole_number(document_, view, "byteStride", name, 0)};
}

}  // namespace kagero
