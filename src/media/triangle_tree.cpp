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

/// Returns true if two triangles have a common vertex, or are the same.
bool share_corner(const TriangleMesh& mesh, std::uint32_t one, std::uint32_t other) {
    const std::uint32_t* const first = &mesh.triangles[3 * std::size_t{one}];
    const std::uint32_t* const second = &mesh.triangles[3 * std::size_t{other}];
    return std::find_first_of(first, first + 3, second, second + 3) != first + 3;
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

/// Returns the distance between two boxes; 0 if they overlap.
double distance(const Bounds& one, const Bounds& other) {
    Double3 gap{};
    for (std::size_t i = 0; i < 3; ++i)
        gap[i] = std::max({one.lower[i] - other.upper[i], 0.0, other.lower[i] - one.upper[i]});
    return length(gap);
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

template <class Reaches, class Visit>
void TriangleTree::visit(const Reaches& reaches, const Visit& visit) const {
    std::array<std::uint32_t, 2 * max_depth_of_tree> pending{};
    std::size_t pending_count = 1;
    while (pending_count > 0) {
        const std::uint32_t index = pending[--pending_count];
        const Node& node = nodes_[index];
        if (!reaches(node.bounds)) continue;
        if (node.count == 0) {
            pending[pending_count++] = node.second_child;
            pending[pending_count++] = index + 1;
            continue;
        }
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) visit(order_[i]);
    }
}

void TriangleTree::add_crossings(const StraightRay& ray, std::uint32_t excluded, Crossing& crossing) const {
    visit(
        [&](const Bounds& box) {
            const double entry = entry_distance(ray, box);
            return entry < std::numeric_limits<double>::infinity() && entry <= crossing.distance;
        },
        [&](std::uint32_t triangle) {
            if (triangle == excluded) return;
            const auto [a, b, c] = corners_of(mesh_, triangle);
            add_triangle(ray, a, b, c, crossing);
        });
}

NearestTriangle TriangleTree::nearest(const Double3& q, std::uint32_t excluded, double limit) const {
    NearestTriangle nearest{limit};
    visit([&](const Bounds& box) { return distance_to_box(q, box) < nearest.distance; },
          [&](std::uint32_t triangle) {
              if (excluded != no_triangle && share_corner(mesh_, triangle, excluded)) return;
              const auto [a, b, c] = corners_of(mesh_, triangle);
              const double distance = length(subtract(q, closest_point(q, a, b, c)));
              if (distance < nearest.distance) nearest = {distance, triangle};
          });
    return nearest;
}

bool TriangleTree::comes_close_to(const TriangleTree& other, double limit) const {
    bool is_close = false;
    const auto reaches = [&](const Bounds& box) { return !is_close && distance(box, other.nodes_[0].bounds) < limit; };
    visit(reaches, [&](std::uint32_t triangle) {
        Bounds bounds;
        for (const Double3& corner : corners_of(mesh_, triangle)) bounds.extend(corner);
        other.visit([&](const Bounds& box) { return !is_close && distance(box, bounds) < limit; },
                    [&](std::uint32_t other_triangle) {
                        Bounds other_bounds;
                        for (const Double3& corner : corners_of(other.mesh_, other_triangle))
                            other_bounds.extend(corner);
                        is_close = is_close || distance(bounds, other_bounds) < limit;
                    });
    });
    return is_close;
}

bool TriangleTree::comes_close_to(const Double3& center, double radius, double limit) const {
    bool is_close = false;
    visit([&](const Bounds& box) { return !is_close && distance_to_box(center, box) < radius + limit; },
          [&](std::uint32_t triangle) {
              const auto corners = corners_of(mesh_, triangle);
              const auto from_center = [&](const Double3& q) { return length(subtract(q, center)); };
              const double nearest = from_center(closest_point(center, corners[0], corners[1], corners[2])),
                           farthest =
                               std::max({from_center(corners[0]), from_center(corners[1]), from_center(corners[2])});
              is_close = is_close || (nearest < radius + limit && farthest > radius - limit);
          });
    return is_close;
}

}  // namespace kagero
