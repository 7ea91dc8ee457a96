/// Diffuse surfaces: their colours, and the directions into which they scatter rays.
#pragma once

#include "plan/plan.h"
#include "rays/sampler.h"

#include <optional>

namespace kagero {

/// A point of a diffuse surface at which a ray arrives.
struct DiffusePoint {
    std::uint32_t medium = 0;                  ///< The medium of the ray (index of Plan::medium).
    std::uint32_t surface = 0, primitive = 0;  ///< The surface, and its triangle.
    Double3 position{};                        ///< In the coordinates of the medium.
    Double3 normal{};                          ///< Unit normal in coordinates, toward the side of the ray.
    /// Unit normal that determines the brightness, on the same side: it is interpolated between the vertex normals of a
    /// mesh. Without them, it is `normal`.
    Double3 shading_normal{};
    double pt = 0;                             ///< p_t of the ray, scaled to |p_t| = 1.
};

/// The share of the light that a surface scatters, and the light that it emits.
struct DiffuseColor {
    Double3 albedo{}, emission{};
};

/// Returns the colour of a diffuse surface, or of a mirror of a mesh file, at a point. `toward` is the unit direction
/// of the ray at its end.
DiffuseColor diffuse_color(const Plan& plan, const DiffusePoint& point, const Double3& toward);

/// The frame in which a diffuse surface is at rest, at one point. In a spacetime, it is the rest frame of the static
/// observer there. In a medium without p_t, it is that of the coordinates, and directions are those of dq/dλ.
class SurfaceFrame {
public:
    /// Returns the frame; nothing if no matter can be at rest at the point, as inside an ergosphere.
    static std::optional<SurfaceFrame> at(const Plan& plan, const DiffusePoint& point);

    /// Returns the unit normal toward the side of the ray, in the axes of the frame.
    const Double3& normal() const { return normal_; }
    /// Returns the unit shading normal, in the axes of the frame.
    const Double3& shading_normal() const { return shading_normal_; }
    /// Returns the start of the ray that leaves the surface in a unit direction of the frame.
    RayStart start_along(const Double3& direction) const;

private:
    SurfaceFrame(const Scene& scene, const DiffusePoint& point) : scene_(scene), point_(point) {}
    /// Sets the shading normal of a frame whose other members are set.
    void set_shading_normal();
    /// Sets the frame of a spacetime from the velocities of three rays, which takes a tenth of the time of an
    /// observer's rest frame. Returns false if not all of these rays exist, or if no matter can be at rest.
    bool set_from_rays();
    /// Sets the frame of a spacetime to the rest frame of the static observer. Returns false if there is none.
    bool set_from_observer();

    const Scene& scene_;
    DiffusePoint point_;
    std::optional<StartMap> map_;  ///< Map from directions to momenta in a spacetime.
    /// Without a map, in a spacetime: the momentum of direction d is offset_ + Σ_b (d · axes_[b]) covectors_[b].
    std::array<Double3, 3> axes_{}, covectors_{};
    Double3 offset_{};
    bool has_covectors_ = false;
    Double3 normal_{}, shading_normal_{};
};

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

/// Chooses directions of scattered rays: with equal probabilities in the cosine distribution or toward a light, if a
/// light is above the horizon of the point. The object keeps its memory from call to call.
class Scatterer {
public:
    explicit Scatterer(const Plan& plan) : plan_(plan) {}

    /// Returns a direction in a frame. `bounce` is the number of surfaces that the path has met before.
    ScatteredDirection scatter(const DiffusePoint& point, const SurfaceFrame& frame, const PixelRay& ray,
                               std::uint32_t bounce);

private:
    const Plan& plan_;
    LightProposals::Around lights_;
};

}  // namespace kagero
