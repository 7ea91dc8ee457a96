/// Diffuse surfaces: their colours, and the directions into which they scatter rays.
#pragma once

#include "appearance/path_state.h"
#include "paths/surface_frame.h"
#include "rays/sampler.h"

namespace kagero {

/// The share of the light that a surface scatters, and the light that it emits.
struct DiffuseColor {
    Double3 albedo{}, emission{};
};

/// Returns the colour of a diffuse surface, or of a mirror of a mesh file, at a point. `toward` is the unit direction
/// of the ray at its end.
DiffuseColor diffuse_color(const Plan& plan, const DiffusePoint& point, const Double3& toward);

/// Returns the unit direction around a normal that belongs to a point in the unit square. Points that fill the square
/// evenly give directions whose density is cos θ/π, with the angle θ from the normal: Malley's method, with the map of
/// concentric_disk (src/rays/sampler.h).
Double3 cosine_direction(const Double3& normal, const std::array<double, 2>& point);

/// A direction into which a surface scatters a ray, and the factor of the light from there: cos θ/π, divided by the
/// probability of the direction per solid angle. θ is the angle from the shading normal. The factor is 0 for directions
/// into the surface, which the normal of the triangle determines.
struct ScatteredDirection {
    Double3 direction{};
    double factor = 1;
};

/// Chooses directions of scattered rays: in the cosine distribution or, if a light is above the horizon of the point,
/// toward a light. The object keeps its memory from call to call.
class Scatterer {
public:
    explicit Scatterer(const Plan& plan) : plan_(plan) {}

    /// Returns a direction in a frame.
    ScatteredDirection scatter(const DiffusePoint& point, const SurfaceFrame& frame, const PixelRay& ray,
                               const PathState& path);

private:
    const Plan& plan_;
    LightProposals::Around lights_;
};

}  // namespace kagero
