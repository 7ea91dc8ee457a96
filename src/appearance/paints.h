/// The colours of a scene's surfaces and skies.
#pragma once

#include "appearance/shading.h"

namespace kagero {

/// A sky with its image.
struct LoadedSky {
    LoadedPaint paint;
    SkyAxes axes{{0, 0, 1}};
};

/// Owns the textures of a scene. Immutable after construction, so any number of threads may shade at once.
class Paints {
public:
    /// Loads the images, or none without `textures` (for ray lists, which have no colours). Refers to the geometry,
    /// which must live as long. Throws InputError for an image that cannot be read.
    Paints(const SceneDescription& scene, const SceneGeometry& geometry, bool textures);

    /// Linear colour of a surface at a point relative to `space.center`; `toward` is the ray's unit direction there
    /// (away from the eye), `redshift` the frequency seen over the frequency sent, which matters to disks. Images and
    /// checkers are averaged over the patch.
    Float3 surface_color(std::uint32_t surface, std::uint32_t primitive, const Double3& point, const Double3& toward,
                         double redshift = 1, const Patch& patch = {}) const;
    /// Linear colour of the sky in a unit direction; `far`: of that of a wormhole's other universe.
    /// Averaged over the footprint where the sky is an image or checkered.
    Float3 sky_color(const Double3& direction, bool far = false, const Footprint& footprint = {}) const;
    /// How many places of an image sky_color looks up for that; 0 where the sky is none.
    int sky_probes(bool far, const Footprint& footprint) const;
    /// Whether footprints on the sky, and patches of surfaces, make a difference: for images and checkers they do.
    bool sky_has_pattern() const;
    bool surfaces_have_patterns() const;

private:
    LoadedSky sky_, far_sky_;
    std::vector<ShadedObject> objects_;  ///< surface i is object i
};

}  // namespace kagero
