/// A scene's surfaces as Embree geometry for the kernels, and their colours for shading.
#pragma once

#include "scene/description.h"

#include <memory>

namespace kagero {

using Float3 = std::array<float, 3>;

/// A small ellipse of directions: its axes, at right angles to each other, with their full lengths in radians.
struct Footprint {
    Double3 major{}, minor{};
};

/// The piece of a surface that a ray stands for: where its end moves to from one ray to the next on its right, and below it; scene lengths.
struct Patch {
    Double3 right{}, below{};
};

/// Owns the Embree scene, the double-precision vertices, the clearance grid and the textures. Immutable after construction, so any
/// number of threads may shade at once.
class SceneGeometry {
public:
    /// What may be left out.
    struct Parts {
        std::uint32_t clearance;  ///< cells along the longest edge of the clearance grid; none if the scene culls nothing
        bool textures;            ///< what colours of surfaces and skies with images need
    };
    static constexpr Parts everything{48, true};

    /// Loads meshes and textures, builds everything wanted. Throws InputError for data that cannot be used.
    explicit SceneGeometry(const SceneDescription& scene, const Parts& wanted = everything);
    ~SceneGeometry();

    /// What the kernels need, in coordinates relative to `space.center`; null when the scene has no objects.
    const Geometry* kernel_view() const;
    /// Linear colour of a surface at a point relative to `space.center`; `toward` is the ray's unit direction there (away from the eye),
    /// `redshift` the frequency seen over the frequency sent, which matters to disks. Images and checkers are averaged over the patch.
    Float3 surface_color(std::uint32_t surface, std::uint32_t primitive, const Double3& point, const Double3& toward,
                         double redshift = 1, const Patch& patch = {}) const;
    /// Whether two places, on primitives of a surface, belong together: on the same face of a box or room; on a mesh only where the way from
    /// one to the other leads along it, and not from one of its parts to another behind.
    bool on_same_face(std::uint32_t surface, std::uint32_t primitive, const Double3& point, std::uint32_t other_primitive, const Double3& other) const;
    /// Linear colour of the sky in a unit direction; `far`: of that of a wormhole's other universe.
    /// Averaged over the footprint where the sky is an image or checkered.
    Float3 sky_color(const Double3& direction, bool far = false, const Footprint& footprint = {}) const;
    /// How many places of an image sky_color looks up for that; 0 where the sky is none.
    int sky_probes(bool far, const Footprint& footprint) const;
    /// Whether footprints on the sky, and patches of surfaces, make a difference: for images and checkers they do.
    bool sky_has_pattern() const;
    bool surfaces_have_patterns() const;
    /// One line per object that the user may want to know of: degenerate triangles skipped, faces triangulated …
    const std::vector<std::string>& remarks() const;
    /// Distance from `space.center` to the nearest point of any object, not greater than `limit`.
    double nearest(double limit) const;
    /// Whether any point of a surface lies within a sphere around `space.center`.
    bool comes_within(std::uint32_t surface, double radius) const;
    /// Diagonal of the box around all objects, scene units; 0 without objects.
    double diagonal() const;

private:
    struct Content;
    std::unique_ptr<Content> content_;
};

}  // namespace kagero
