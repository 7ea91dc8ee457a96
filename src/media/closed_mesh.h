/// Checks that a mesh encloses a region: it must be closed and consistently oriented.
#pragma once

#include "geometry/shapes.h"

#include <string>

namespace kagero {

/// The result of the check of a mesh. Vertices at the same position count as one vertex.
struct ClosedMesh {
    /// Reason why the mesh is not the surface of a region, as the end of a sentence about the object; empty if it is.
    std::string defect;
    /// Enclosed volume: positive if the normals of the triangles point outward, negative if they point inward.
    double signed_volume = 0;
};

/// Checks a mesh. In the reason, positions are converted to lengths of the scene file: (q + space_center)·unit.
ClosedMesh check_closed(const TriangleMesh& mesh, const Double3& space_center, double unit);

}  // namespace kagero
