#include "media/closed_mesh.h"

#include "scene/value.h"
#include "scene/vector3.h"

#include <algorithm>
#include <numeric>

namespace kagero {
namespace {

/// Returns for each vertex the index of the first vertex, in a sorted order, at the same position.
std::vector<std::uint32_t> weld(const TriangleMesh& mesh) {
    std::vector<std::uint32_t> order(mesh.vertices.size() / 3), welded(order.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t one, std::uint32_t other) { return vertex(mesh, one) < vertex(mesh, other); });
    for (std::size_t i = 0; i < order.size(); ++i) {
        const bool same = i > 0 && vertex(mesh, order[i]) == vertex(mesh, order[i - 1]);
        welded[order[i]] = same ? welded[order[i - 1]] : order[i];
    }
    return welded;
}

/// An edge of a triangle, from its vertex with the lower index. `forward` is true if the triangle traverses it so.
struct Edge {
    std::uint32_t low, high;
    bool forward;
    bool has_ends_of(const Edge& other) const { return low == other.low && high == other.high; }
};

/// Returns the edges of all triangles, sorted by their ends.
std::vector<Edge> edges_of(const TriangleMesh& mesh) {
    const std::vector<std::uint32_t> welded = weld(mesh);
    std::vector<Edge> edges;
    edges.reserve(mesh.triangles.size());
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const std::size_t next = i % 3 == 2 ? i - 2 : i + 1;
        const std::uint32_t from = welded[mesh.triangles[i]], to = welded[mesh.triangles[next]];
        edges.push_back({std::min(from, to), std::max(from, to), from < to});
    }
    std::sort(edges.begin(), edges.end(), [](const Edge& one, const Edge& other) {
        return one.low != other.low ? one.low < other.low : one.high < other.high;
    });
    return edges;
}

/// Edges of one kind: their number, and one of them.
struct EdgeCount {
    std::size_t count = 0;
    Edge example{};

    void add(const Edge& edge) {
        if (count++ == 0) example = edge;
    }
};

/// Returns the number of edges, such as "3 edges belong" or "1 edge belongs".
std::string count_text(std::size_t count) {
    return std::to_string(count) + (count == 1 ? " edge belongs" : " edges belong");
}

}  // namespace

ClosedMesh check_closed(const TriangleMesh& mesh, const Double3& space_center, double unit) {
    ClosedMesh result;
    const Double3 origin = vertex(mesh, mesh.triangles.front());
    for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
        const std::uint32_t* index = &mesh.triangles[i];
        const Double3 a = subtract(vertex(mesh, index[0]), origin), b = subtract(vertex(mesh, index[1]), origin),
                      c = subtract(vertex(mesh, index[2]), origin);
        result.signed_volume += dot(a, cross(b, c)) / 6;
    }
    EdgeCount open, reversed, shared;
    const std::vector<Edge> edges = edges_of(mesh);
    for (std::size_t i = 0; i < edges.size();) {
        std::size_t end = i, forward = 0;
        for (; end < edges.size() && edges[end].has_ends_of(edges[i]); ++end) forward += edges[end].forward;
        const std::size_t total = end - i;
        if (total == 1) open.add(edges[i]);
        else if (total > 2) shared.add(edges[i]);
        else if (forward != 1) reversed.add(edges[i]);
        i = end;
    }
    const auto where = [&](const EdgeCount& edges_of_kind) {
        const auto position = [&](std::uint32_t index) {
            return to_toml(scaled(add(vertex(mesh, index), space_center), unit));
        };
        return ", for example that from " + position(edges_of_kind.example.low) + " to " +
               position(edges_of_kind.example.high);
    };
    if (open.count > 0)
        result.defect =
            "is open: " + count_text(open.count) + " to one triangle only" + where(open) + "; close the mesh";
    else if (shared.count > 0)
        result.defect = "is not the surface of one region: " + count_text(shared.count) +
                        " to more than two triangles" + where(shared) +
                        "; divide the mesh into closed parts that do not touch";
    else if (reversed.count > 0)
        result.defect = "is not consistently oriented: " + count_text(reversed.count) +
                        " to two triangles that traverse it in the same direction" + where(reversed) +
                        "; reverse the triangles on one side of such edges";
    return result;
}

}  // namespace kagero
