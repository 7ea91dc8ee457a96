/// The regions into which the boundaries of a scene divide space, and the medium of each.
#pragma once

#include "media/boundaries.h"
#include "media/close_surfaces.h"

namespace kagero {

/// The regions of a scene with at least one boundary. Coordinates are relative to `space.center`, in the unit of the
/// kernels. The medium of a point is that in front of the first boundary on a straight ray from it.
class Regions {
public:
    /// Finds the boundaries and checks them. Throws InputError if a boundary is not a closed surface, or if boundaries
    /// state different media for one region. `geometry` must outlive the regions; `unit` is Scene::unit.
    Regions(const SceneDescription& scene, const SceneGeometry& geometry, double unit);

    /// Returns 1 if the planes of a boundary that the kernels use have normals that point to its exterior, −1 if they
    /// point to its interior. Returns 1 for spheres, and for surfaces that are not boundaries.
    int outward_sign(std::uint32_t surface) const { return outward_signs_[surface]; }
    /// Returns the index of the medium at q. If q lies on a boundary within rounding, the medium is that of one of its
    /// sides. Throws InputError if boundaries of different media coincide around q.
    std::uint32_t medium_at(const Double3& q) const { return first_boundary(q).medium; }
    /// Returns the medium into which a ray moves that starts at q with the unit direction `direction`. A ray that is
    /// tangent to a sphere moves out of it.
    std::uint32_t medium_ahead(const Double3& q, const Double3& direction) const;
    /// Returns the medium beside the point q of a boundary, on the side to which the unit vector `normal` points.
    std::uint32_t medium_beside(std::uint32_t surface, const Double3& q, const Double3& normal) const;
    /// Returns the size of a boundary.
    double size_of(std::uint32_t surface) const;
    /// Returns true if another boundary touches a boundary at q within rounding. The media on both sides are then those
    /// of medium_beside, and not always those that the object states.
    bool is_contact(std::uint32_t surface, std::uint32_t primitive, const Double3& q, const Double3& normal) const;
    /// Returns the first boundary on a ray from q, in a direction in which this boundary is certain.
    FirstBoundary first_boundary(const Double3& q) const;
    /// Returns the surfaces that touch or nearly touch a boundary.
    const CloseSurfaces& close_surfaces() const { return close_surfaces_; }

private:
    const MediumBoundary& boundary_of(std::uint32_t surface) const;

    Boundaries boundaries_;
    CloseSurfaces close_surfaces_;
    std::vector<int> outward_signs_;
    bool has_contacts_ = false;          ///< True if boundaries may touch each other.
    double greatest_file_rounding_ = 0;  ///< The greatest ExactSurface::file_rounding of a boundary.
    std::string names_;                  ///< Names of the boundaries, for messages.
};

/// Returns true if the scene has a boundary.
bool has_boundaries(const SceneDescription& scene);

/// Returns the index of the medium around the camera. Throws InputError if the scene states another one. `regions` is
/// null if the scene has no boundaries; `unit` is Scene::unit.
std::uint32_t check_camera_medium(const SceneDescription& scene, const Regions* regions, double unit);

}  // namespace kagero
