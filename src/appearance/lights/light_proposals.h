/// Directions from a point of a surface toward the lights of a scene, as proposals for scattered rays.
///
/// A straight line to a light is only a guess where light bends: the ray is traced, and finds what it finds. Its weight
/// divides by the probability of its direction, so the mean of the light is right whatever the ray meets.
#pragma once

#include "appearance/lights/sky_distribution.h"
#include "geometry/geometry.h"

namespace kagero {

/// The lights of a scene: surfaces that emit light, as the spheres around them, and the bright parts of the sky.
class LightProposals {
public:
    /// Directions toward the lights that are above the horizon of one point, with the weights of the lights.
    class Around;

    /// Finds the lights. The images of `paints` must be loaded, or all skies count as even.
    LightProposals(const SceneDescription& scene, const SceneGeometry& geometry, const Paints& paints);

    /// Returns true if the scene has no light toward which rays are worth sending.
    bool empty() const { return lights_.empty() && !sky_; }

private:
    /// A light: the sphere around it, relative to `space.center`, and its luminance.
    struct Light {
        Double3 center{};
        double radius = 0, luminance = 0;
    };

    std::vector<Light> lights_;
    std::optional<SkyDistribution> sky_;
};

/// Owns its memory, so that it can be used for many points.
class LightProposals::Around {
public:
    /// Prepares for a point, relative to `space.center`, with the unit normal `normal`. Returns false if no light is
    /// above its horizon, or only lights around the point.
    bool set(const LightProposals& proposals, const Double3& point, const Double3& normal);
    /// Returns the unit direction that belongs to a number in [0, 1), which selects the light, and a point in the unit
    /// square.
    Double3 direction(double number, const std::array<double, 2>& point) const;
    /// Returns the probability per solid angle of a unit direction.
    double density(const Double3& direction) const;

private:
    /// A cone of directions around a light.
    struct Cone {
        Double3 axis{};
        double height = 0;  ///< 1 − cos of half its opening angle.
        double weight = 0;
    };

    std::vector<Cone> cones_;
    const SkyDistribution* sky_ = nullptr;
    double sky_weight_ = 0, total_ = 0;
};

}  // namespace kagero
