#include "media/triangle_tree.h"

#include "geometry/clearance/clearance.h"

#include <algorithm>
#include <numeric>

namespace kagero {
namespace {

constexpr std::uint32_t leaf_size = 4;

/// Greatest depth of a tree: each level halves the number of triangles, of which there are less than 2³².
constexpr std::size_t max_depth_of_tree = 33;

/// Returns the corners of a triangle.
std::array<Double3, 3> corners_of(const TriangleMesh& mesh, std::uint32_t triangle) {
    const std::uint32_t* index = &mesh.triangles[3 * std::size_t{triangle}];
    return {vertex(mesh, index[0]), vertex(mesh, index[1]), vertex(mesh, index[2])};
}

/// Returns the distance at which a ray enters a box, 0 if it starts inside, or infinity if it misses the box.
double entry_distance(const StraightRay& ray, const Bounds& box) {
    double entry = 0, exit = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < 3; ++i) {
        const double inverse = 1 / ray.direction[i];
        const double to_lower = (box.lower[i] - ray.origin[i]) * inverse,
                     to_upper = (box.upper[i] - ray.origin[i]) * inverse;
        entry = std::max(entry, std::min(to_lower, to_upper));
        exit = std::min(exit, std::max(to_lower, to_upper));
    }
    return entry <= exit ? entry : std::numeric_limits<double>::infinity();
}

/// Returns the distance from a point to a box.
double distance_to_box(const Double3& q, const Bounds& box) {
    Double3 offset{};
    for (std::size_t i = 0; i < 3; ++i) offset[i] = std::max({box.lower[i] - q[i], 0.0, q[i] - box.upper[i]});
    return length(offset);
}

}  // namespace

TriangleTree::TriangleTree(const TriangleMesh& mesh) : mesh_(mesh), order_(mesh.triangles.size() / 3) {
    std::iota(order_.begin(), order_.end(), 0u);
    for (const std::uint32_t triangle : order_) {
        const auto [a, b, c] = corners_of(mesh, triangle);
        centroids_.push_back(scaled(add(add(a, b), c), 1.0 / 3));
    }
    nodes_.reserve(order_.size());
    build(0, static_cast<std::uint32_t>(order_.size()));
    centroids_ = {};
}

/// Returns the bounding box of triangles of `order_`, enlarged by the rounding errors of entry_distance.
Bounds TriangleTree::bounds_of_triangles(std::uint32_t first, std::uint32_t count) const {
    constexpr double rounding = 1e-12;
    Bounds bounds;
    double greatest = 0;
    for (std::uint32_t i = first; i < first + count; ++i)
        for (const Double3& corner : corners_of(mesh_, order_[i])) {
            bounds.extend(corner);
            for (const double x : corner) greatest = std::max(greatest, std::abs(x));
        }
    for (std::size_t i = 0; i < 3; ++i) {
        bounds.lower[i] -= rounding * greatest;
        bounds.upper[i] += rounding * greatest;
    }
    return bounds;
}

/// Appends the node of `count` triangles of `order_`, and its children. The triangles are divided at the median of
/// their centroids along the longest edge of the box.
void TriangleTree::build(std::uint32_t first, std::uint32_t count) {
    const std::size_t node = nodes_.size();
    const Bounds bounds = bounds_of_triangles(first, count);
    nodes_.push_back({bounds, first, count, 0});
    if (count <= leaf_size) return;
    std::size_t axis = 0;
    for (std::size_t i = 1; i < 3; ++i)
        if (bounds.upper[i] - bounds.lower[i] > bounds.upper[axis] - bounds.lower[axis]) axis = i;
    const std::uint32_t half = count / 2;
    const auto begin = order_.begin() + first;
    std::nth_element(begin, begin + half, begin + count, [&](std::uint32_t one, std::uint32_t other) {
        return centroids_[one][axis] < centroids_[other][axis];
    });
    nodes_[node].count = 0;
    build(first, half);
    nodes_[node].second_child = static_cast<std::uint32_t>(nodes_.size());
    build(first + half, count - half);
}

void TriangleTree::add_crossings(const StraightRay& ray, std::uint32_t excluded, Crossing& crossing) const {
    std::array<std::uint32_t, 2 * max_depth_of_tree> pending{};
    std::size_t pending_count = 1;
    while (pending_count > 0) {
        const std::uint32_t index = pending[--pending_count];
        const Node& node = nodes_[index];
        const double entry = entry_distance(ray, node.bounds);
        if (!(entry < std::numeric_limits<double>::infinity()) || entry > crossing.distance) continue;
        if (node.count == 0) {
            pending[pending_count++] = node.second_child;
            pending[pending_count++] = index + 1;
            continue;
        }
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
            if (order_[i] == excluded) continue;
            const auto [a, b, c] = corners_of(mesh_, order_[i]);
            add_triangle(ray, a, b, c, crossing);
        }
    }
}

double TriangleTree::distance(const Double3& q, std::uint32_t excluded, double limit) const {
    std::array<std::uint32_t, 2 * max_depth_of_tree> pending{};
    std::size_t pending_count = 1;
    while (pending_count > 0) {
        const std::uint32_t index = pending[--pending_count];
        const Node& node = nodes_[index];
        if (distance_to_box(q, node.bounds) >= limit) continue;
        if (node.count == 0) {
            pending[pending_count++] = node.second_child;
            pending[pending_count++] = index + 1;
            continue;
        }
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
            if (order_[i] == excluded) continue;
            const auto [a, b, c] = corners_of(mesh_, order_[i]);
            limit = std::min(limit, length(subtract(q, closest_point(q, a, b, c))));
        }
    }
    return limit;
}

}  // namespace kagero
