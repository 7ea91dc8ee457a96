/// A tree of bounding boxes over the triangles of a mesh, in double precision.
#pragma once

#include "geometry/clearance/bounds.h"
#include "geometry/shapes.h"
#include "media/crossing.h"

namespace kagero {

/// The triangle nearest to a point. Its index is no_triangle, and the distance the limit, if none is near enough.
struct NearestTriangle {
    double distance;
    std::uint32_t triangle = no_triangle;
};

/// Answers queries about the triangles of a mesh. The mesh must outlive the tree.
class TriangleTree {
public:
    explicit TriangleTree(const TriangleMesh& mesh);

    /// Adds the first crossing with the triangles, except the triangle `excluded`.
    void add_crossings(const StraightRay& ray, std::uint32_t excluded, Crossing& crossing) const;
    /// Returns the triangle nearest to q among those nearer than `limit`, without `excluded` and those that share a
    /// corner with it.
    NearestTriangle nearest(const Double3& q, std::uint32_t excluded, double limit) const;
    /// Returns true if a triangle comes closer than `limit` to the bounding box of a triangle of another tree.
    bool comes_close_to(const TriangleTree& other, double limit) const;
    /// Returns true if a triangle comes closer than `limit` to a sphere.
    bool comes_close_to(const Double3& center, double radius, double limit) const;

private:
    /// A node. Its first child follows it directly. A leaf contains `count` triangles of `order_`.
    struct Node {
        Bounds bounds;
        std::uint32_t first = 0, count = 0, second_child = 0;
    };

    /// Calls visit(triangle) for the triangles of all leaves whose box `reaches` accepts, and whose ancestors it
    /// accepts.
    template <class Reaches, class Visit>
    void visit(const Reaches& reaches, const Visit& visit) const;
    void build(std::uint32_t first, std::uint32_t count);
    Bounds bounds_of_triangles(std::uint32_t first, std::uint32_t count) const;

    const TriangleMesh& mesh_;
    std::vector<Double3> centroids_;  ///< Only during construction.
    std::vector<std::uint32_t> order_;
    std::vector<Node> nodes_;
};

}  // namespace kagero
