/// The frames in which diffuse surfaces are at rest.
#pragma once

#include "plan/plan.h"

#include <array>
#include <optional>
#include <span>
#include <vector>

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
    double pt = 0;      ///< p_t of the ray, scaled to |p_t| = 1.
    double albedo = 0;  ///< Share of the light that the surface scatters: the greatest of the colours.
};

/// The frame in which a diffuse surface is at rest, at one point. In a spacetime, it is the rest frame of the static
/// observer there. In a medium without p_t, it is that of the coordinates, and directions are those of dq/dλ.
class SurfaceFrame {
public:
    /// Returns false if no matter can be at rest at the point, as inside an ergosphere. The frame then has no other
    /// use.
    bool exists() const { return exists_; }
    /// Returns the unit normal toward the side of the ray, in the axes of the frame.
    const Double3& normal() const { return normal_; }
    /// Returns the unit shading normal, in the axes of the frame.
    const Double3& shading_normal() const { return shading_normal_; }
    /// Returns the start of the ray that leaves the surface in a unit direction of the frame.
    RayStart start_along(const Double3& direction) const;

private:
    friend class SurfaceFrames;
    static constexpr std::size_t test_rays = 3;  ///< Number of rays whose velocities determine a frame.

    /// Begins the frame at a point.
    void begin(const Scene& scene, const DiffusePoint& point);
    /// Sets the offset of the momenta, and makes the rays whose velocities determine the frame. `tilt` is that of
    /// Module::time_tilts.
    void make_test_rays(const double (&tilt)[3], std::span<SurfaceRay, test_rays> rays);
    /// Sets the frame of a spacetime from the velocities of its test rays, which takes a tenth of the time of an
    /// observer's rest frame. Returns false if not all of these rays exist, or if no matter can be at rest.
    bool set_from_rays(std::span<const Continuation, test_rays> rays);
    /// Sets the frame of a spacetime to the rest frame of the static observer. Returns false if there is none.
    bool set_from_observer();
    /// Sets the shading normal of a frame whose other members are set.
    void set_shading_normal();

    const Scene* scene_ = nullptr;
    DiffusePoint point_;
    bool exists_ = false, has_covectors_ = false;
    /// With covectors: the momentum of direction d is offset_ + Σ_b (d · axes_[b]) covectors_[b].
    std::array<Double3, 3> axes_{}, covectors_{};
    Double3 offset_{};
    Double3 normal_{}, shading_normal_{};
    std::optional<StartMap> map_;  ///< Map from directions to momenta in a spacetime, if there are no covectors.
};

/// Computes the frames of many points at once, in full packets. The object keeps its memory from call to call.
class SurfaceFrames {
public:
    explicit SurfaceFrames(const Plan& plan) : plan_(plan) {}

    /// Returns the frames at points. The result is valid until the next call.
    std::span<const SurfaceFrame> at(std::span<const DiffusePoint> points);

private:
    /// Sets the frames at points in one medium. Those of a spacetime are set from test rays where these exist.
    void set_frames(const Scene& scene, std::span<const DiffusePoint> points, SurfaceFrame* frames);

    /// A momentum vector of Module::time_tilts.
    struct TimeTilt {
        double vector[3];
    };

    const Plan& plan_;
    std::vector<SurfaceFrame> frames_;
    std::vector<SurfaceRay> normals_;  ///< One along the normal of each point.
    std::vector<TimeTilt> tilts_;
    std::vector<SurfaceRay> rays_;  ///< The test rays of all points.
    std::vector<Continuation> continuations_;
};

}  // namespace kagero
