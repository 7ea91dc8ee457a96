/// What a page shows: the keys of the scene that it has changed, the layer, and the quality of the picture.
#pragma once

#include "scene/description.h"

namespace kagero {

/// The quality of a picture.
enum class Quality {
    moving,  ///< As good as a short time permits, because the next picture differs.
    full,    ///< The whole picture, as `kagero render` computes it with one ray per pixel.
    fine,    ///< The whole picture with several rays per pixel.
};

/// A picture that a page requests.
struct ViewState {
    std::string tab;  ///< Identifies the page; letters and digits.
    /// Keys of the scene and their values as TOML, in the order of the request. Only live keys are possible.
    std::vector<std::pair<std::string, std::string>> keys;
    std::string layer = "color";
    std::uint32_t width = 0, height = 0;  ///< Size of the picture in pixels.
    std::uint32_t spp = 1;                ///< Rays per pixel, for Quality::fine.
    Quality quality = Quality::full;

    /// Returns the keys as overrides of the scene.
    std::vector<Override> overrides() const;
};

/// Bounds on the pictures that a page can request.
inline constexpr std::uint32_t min_view_edge = 1, max_view_edge = 4096, max_view_pixels = 1 << 23, max_view_spp = 64;

/// Returns true if a page may set this key of the scene. Such keys are listed one by one, and none of them names a
/// file: the camera, the parameters of the space, the texts and constants of a formula, and the tone of the picture.
bool is_live_key(const SceneDescription& scene, const std::string& key);

/// Returns true if the key changes only the direction of the view, its field of view, or the colours of the display,
/// so that the rays from the camera's position remain the same.
bool keeps_rays(const std::string& key);

/// Reads a request, which is JSON. Throws InputError if anything in it is invalid.
ViewState parse_view_state(const std::string& json, const SceneDescription& scene);

}  // namespace kagero
