/// A tree of bounding boxes over the triangles of a mesh, in double precision.
#pragma once

#include "geometry/clearance/bounds.h"
#include "geometry/shapes.h"
#include "media/crossing.h"

namespace kagero {

/// Answers queries about the triangles of a mesh. The mesh must outlive the tree.
class TriangleTree {
public:
    explicit TriangleTree(const TriangleMesh& mesh);

    /// Adds the first crossing with the triangles, except the triangle `excluded`.
    void add_crossings(const StraightRay& ray, std::uint32_t excluded, Crossing& crossing) const;
    /// Returns the distance from q to the nearest triangle other than `excluded`, or `limit` if that is smaller.
    double distance(const Double3& q, std::uint32_t excluded, double limit) const;

private:
    /// A node. Its first child follows it directly. A leaf contains `count` triangles of `order_`.
    struct Node {
        Bounds bounds;
        std::uint32_t first = 0, count = 0, second_child = 0;
    };

    void build(std::uint32_t first, std::uint32_t count);
    Bounds bounds_of_triangles(std::uint32_t first, std::uint32_t count) const;

    const TriangleMesh& mesh_;
    std::vector<Double3> centroids_;  ///< Only during construction.
    std::vector<std::uint32_t> order_;
    std::vector<Node> nodes_;
};

}  // namespace kagero
