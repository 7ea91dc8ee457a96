/// Rays through the centres of some pixels of a tile, from whose ends those of the other pixels are interpolated.
#pragma once

#include "paths/trace_paths.h"
#include "scene/vector3.h"

#include <span>
#include <vector>

namespace kagero {

/// A point of the path of a ray, in the coordinates of the Hamiltonian.
struct PathVertex {
    Double3 position, direction;  ///< The direction is a unit vector.
    double length;                ///< Length of the path from its start, as the sum of chords.
};

/// A pixel, as its column and row in a tile. The tile has the pixels from 0 to edge − 1. Nodes can also lie in the next
/// column and row, at `edge`, which belong to other tiles.
struct NodePosition {
    std::uint32_t x, y;
};

/// Traces rays through pixel centres of one tile after another, and keeps their ends. A ray is traced once, however
/// often it is requested, unless its path is requested later.
class RayNodes {
public:
    /// Begins with a tile without rays. The tile has `edge` × `edge` pixels, of which the first one is pixel (x0, y0)
    /// of the film. The plan must outlive the calls of other functions.
    void begin(const Plan& plan, const Job& job, std::uint32_t x0, std::uint32_t y0, std::uint32_t edge);

    /// Requests a ray. It has no end until trace() is called.
    void request(NodePosition at);
    /// Requests a ray and its path.
    void request_with_path(NodePosition at);
    /// Traces all rays that were requested since the last call. Adds their steps to the counters.
    void trace(Counters& counters);

    const RayEnd& end(NodePosition at) const { return ends_[index_[place(at)]]; }
    /// Returns the vertices of the path of a ray: at least two if its path was requested and the ray did not fail.
    std::span<const PathVertex> path(NodePosition at) const;
    /// Returns the ends of all rays that were traced for the tile.
    const std::vector<RayEnd>& ends() const { return ends_; }

private:
    /// Rays that are requested, but not traced.
    struct Requests {
        RayList rays;
        std::vector<std::size_t> places;  ///< Their elements of `index_`.
    };
    /// A vertex of the path of the ray `ray` of the current list.
    struct ReportedVertex {
        std::uint64_t ray;
        PathVertex vertex;
    };

    std::size_t place(NodePosition at) const { return std::size_t{at.y} * (edge_ + 1) + at.x; }
    void add(NodePosition at, Requests& requests);
    void trace(Requests& requests, const Job& job, Counters& counters);
    void trace_paths(Counters& counters);
    void report(const PathPoint& point);
    void add_vertices(std::size_t first_ray);

    const Plan* plan_ = nullptr;
    Job job_{};
    std::uint32_t x0_ = 0, y0_ = 0, edge_ = 0;
    double cosine_of_turn_ = 1;  ///< Cosine of the greatest angle between vertices of a path.
    static constexpr std::uint32_t is_absent = ~0u, is_requested = is_absent - 1;
    std::vector<std::uint32_t>
        index_;  ///< Index of the ray of each position in `ends_`, or one of the constants above.
    Requests without_path_, with_path_;
    std::vector<RayEnd> ends_, new_ends_;
    std::vector<ReportedVertex> reported_;  ///< Vertices of the paths of the current list, without their last ones.
    std::vector<PathVertex> last_points_;   ///< The last point of the path of each ray of the current list.
    std::vector<Double3> last_directions_;  ///< The direction at the last vertex of each ray of the current list.
    std::vector<PathVertex> vertices_;      ///< The paths of all rays, one after the other.
    std::vector<std::size_t> first_vertex_, next_vertex_;  ///< Indices in `vertices_`, one for each ray and one more.
};

}  // namespace kagero
