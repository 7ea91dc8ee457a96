/// Colours of the surfaces and skies of a scene.
#pragma once

#include "appearance/shading.h"

#include <memory>
#include <vector>

namespace kagero {

/// Paint and axes of a sky.
struct LoadedSky {
    LoadedPaint paint;
    SkyAxes axes{{0, 0, 1}};
};

/// The images of the paints of a scene (paints.cpp).
struct LoadedImages;

/// Owns the textures of a scene. Immutable after construction, so any number of threads may use it concurrently.
class Paints {
public:
    /// Loads the images of the textures if `with_images` is true. Colours of textures are available only then. Keeps
    /// pointers into `geometry`, which must outlive this object. `earlier`, if not null, contains the paints of another
    /// frame, whose images are used again. Throws InputError if an image cannot be read.
    Paints(const SceneDescription& scene, const SceneGeometry& geometry, bool with_images,
           const Paints* earlier = nullptr);

    /// Returns the linear colour of a surface at a point relative to `space.center`. `ray_direction` is the unit
    /// direction of the ray at its end, traced from the camera. `redshift` is the observed frequency divided by the
    /// emitted one; it affects only disks. Images and checkers are averaged over the patch.
    /// If `black_body` is not null, it is the colour of the disk's black body, which is otherwise computed.
    Float3 surface_color(std::uint32_t surface, std::uint32_t primitive, const Double3& point,
                         const Double3& ray_direction, double redshift = 1, const Patch& patch = {},
                         const Float3* black_body = nullptr) const;
    /// Returns the light that a part of a mesh file emits at a point relative to `space.center`.
    Float3 emission_color(std::uint32_t surface, std::uint32_t primitive, const Double3& point) const {
        return kagero::emission_color(objects_[surface], primitive, point);
    }
    /// Returns the linear colour of the sky in a unit direction. If `on_second_sheet` is true, the sky is that of a
    /// wormhole's second sheet. Images and checkers are averaged over the filter's footprint.
    Float3 sky_color(const Double3& direction, bool on_second_sheet = false, const SkyFilter& filter = {}) const;
    /// Returns the data of a surface.
    const ShadedObject& object(std::uint32_t surface) const { return objects_[surface]; }
    /// Returns the paint and the axes of a sky.
    const LoadedSky& sky(bool on_second_sheet) const { return on_second_sheet ? far_sky_ : sky_; }
    /// Returns the filter for a footprint on a sky.
    SkyFilter sky_filter(bool on_second_sheet, const Footprint& footprint) const;
    /// Returns true if a sky has an image or a checker, so that footprints affect its colour.
    bool sky_has_pattern() const;
    /// Returns true if a surface has an image or a checker, so that patches affect its colour.
    bool surfaces_have_patterns() const;

private:
    LoadedSky sky_, far_sky_;
    std::shared_ptr<const LoadedImages> images_;  ///< All images of the paints.
    std::vector<ShadedObject> objects_;           ///< One per surface, in the same order.
};

}  // namespace kagero
