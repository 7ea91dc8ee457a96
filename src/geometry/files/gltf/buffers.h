/// Binary data of glTF files: buffers and the views of them.
#pragma once

#include "geometry/files/gltf/document.h"

#include <map>

namespace kagero {

/// Part of a buffer.
struct GltfView {
    std::string_view bytes;
    std::size_t stride = 0;  ///< Distance of elements in bytes; 0 if they follow each other.
};

/// Returns the path of the file that a glTF file at `path` names.
std::string path_of_gltf_uri(const std::string& path, const std::string& uri);

/// Returns the bytes that a URI of the scheme "data" contains. `name` is the position of the object with this URI.
std::string embedded_bytes(const GltfDocument& document, const std::string& uri, const std::string& name);

/// The buffers of a file. A buffer is read when it is used for the first time: from the binary chunk, from the text of
/// the file, or from another file.
class GltfBuffers {
public:
    explicit GltfBuffers(const GltfDocument& document) : document_(document) {}

    /// Returns a part of a buffer. Throws InputError if the buffer does not contain it. The bytes are valid as long as
    /// this object.
    GltfView view(std::uint64_t index);

private:
    std::string_view buffer(std::uint64_t index);
    std::string read_uri(const std::string& uri, const std::string& name) const;

    const GltfDocument& document_;
    std::map<std::uint64_t, std::string> buffers_;  ///< Bytes of the buffers that have been read.
};

}  // namespace kagero
