/// Materials of mesh files.
#pragma once

#include "scene/description.h"

#include <map>

namespace kagero {

/// An image that a material names, or that the mesh file contains.
struct FileTexture {
    std::string path;                          ///< Path of the image, or the name of an image in the mesh file.
    std::shared_ptr<const std::string> bytes;  ///< Bytes of an image in the mesh file; null for an image file.
    BeyondEdge along_u = BeyondEdge::repeat, along_v = BeyondEdge::repeat;
};

/// A map of texture coordinates: (u, v) are scaled, then rotated, then moved.
struct UvTransform {
    std::array<double, 2> offset{0, 0}, scale{1, 1};
    double rotation = 0;  ///< Radian; turns v toward u.

    std::array<double, 2> operator()(const std::array<double, 2>& uv) const;
    bool operator==(const UvTransform&) const = default;
};

/// The properties of a material that kagero uses, and the names of those that it does not use.
struct FileMaterial {
    std::string name;              ///< Name for messages.
    Double3 color{0.8, 0.8, 0.8};  ///< The share of the light that is scattered or reflected, or a factor of it.
    std::optional<FileTexture> color_texture;
    Double3 emission{0, 0, 0};  ///< The emitted light, or a factor of it.
    std::optional<FileTexture> emission_texture;
    double metallic = 0;                          ///< 1: the surface reflects light; 0: it scatters light.
    std::optional<FileTexture> metallic_texture;  ///< Factors of `metallic`, in the blue channel, not sRGB-encoded.
    bool is_unlit = false;                        ///< The surface always has its colour.
    std::uint64_t uv_set = 0;                     ///< Number of the texture coordinates that its textures use.
    UvTransform uv_transform;
    std::vector<std::string> unused;  ///< Names of other properties that the file states.
};

/// Returns one remark for each property that is not used, with the names of the materials that state it.
std::vector<std::string> remarks_on_unused(const std::vector<FileMaterial>& materials);

}  // namespace kagero
