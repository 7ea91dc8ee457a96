/// Segments of paths: the rays of one generation, and what they add to their paths.
#pragma once

#include "appearance/path_state.h"
#include "rays/list_rays.h"

namespace kagero {

/// Rays that start in one medium in the next generation.
struct Segments {
    std::vector<std::uint32_t> rays;  ///< Their indices in the tile.
    RayList list;

    void add(std::uint32_t ray, const RayStart& start) {
        rays.push_back(ray);
        list.starts.push_back(start);
    }
    void clear() {
        rays.clear();
        list.starts.clear();
    }
};

/// Adds a position in the coordinates of a medium to those of the space of the scene.
void to_space(const Plan& plan, std::uint32_t medium, double (&q)[3]);

/// Adds the sums over the segments of a path to those of a further segment, which is then the end of the path. The
/// integrals are added if `has_integrals` is true.
void append(const RayEnd& path, RayEnd& segment, bool has_integrals);

/// Passes the points of a segment to the sink of the job, as points of the whole path.
struct PathPoints {
    const Plan& plan;
    const Job& job;
    const std::vector<RayEnd>& ends;             ///< The ends of the paths before these segments, by ray.
    const std::vector<PathState>& paths;         ///< By ray.
    const std::vector<std::uint32_t>& segments;  ///< The ray of each segment.
    std::uint64_t first_ray;                     ///< Index of the tile's first ray in the list of the job.

    /// Job::path_sink; `user` is this object.
    static void receive(void* user, const PathPoint* point);
};

}  // namespace kagero
