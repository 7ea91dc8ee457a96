/// Segments of paths: the rays of one generation, and what they add to their paths.
#pragma once

#include "appearance/path_state.h"
#include "rays/list_rays.h"

namespace kagero {

/// Rays that start in one medium in the next generation.
struct Segments {
    std::vector<std::uint32_t> rays;  ///< Their indices in the tile.
    RayList list;
    bool has_scattered_rays = false;  ///< Some rays leave a diffuse surface, in random directions.

    void add(std::uint32_t ray, const RayStart& start) {
        rays.push_back(ray);
        list.starts.push_back(start);
    }
    void clear() {
        rays.clear();
        list.starts.clear();
        has_scattered_rays = false;
    }
    /// Groups the rays by the signs of the components of their momenta. Rays in a packet then meet the same surfaces
    /// more often.
    void group_by_octant();

private:
    std::vector<std::uint32_t> grouped_rays_;  ///< Memory of group_by_octant.
    std::vector<RayStart> grouped_starts_;
};

/// Adds a position in the coordinates of a medium to those of the space of the scene.
void to_space(const Plan& plan, std::uint32_t medium, double (&q)[3]);

/// Adds the sums over the segments of a path to those of a further segment, which is then the end of the path. The
/// integrals are added if `has_integrals` is true.
void append(const RayEnd& path, RayEnd& segment, bool has_integrals);

/// Passes the points of the segments of one medium to the sink of a job, as points of the whole paths.
class PathPoints {
public:
    /// `ends` are the ends of the paths before these segments, and `paths` their states, both by ray. `segments`
    /// contains the ray of each segment. `first_ray` is the index of the tile's first ray in the list of `job`. If
    /// `adds_action_to_time` is true, the kernel computes the action instead of the time, whose rate is its negative.
    PathPoints(const Plan& plan, const Job& job, const std::vector<RayEnd>& ends, const std::vector<PathState>& paths,
               const std::vector<std::uint32_t>& segments, std::uint64_t first_ray, bool adds_action_to_time);

    /// Makes the kernel that runs `job_of_segments` pass its points to this object, if the job of the constructor has a
    /// sink. This object must outlive the run.
    void install(Job& job_of_segments);

private:
    static void receive(void* user, const PathPoint* point);
    void pass_on(PathPoint point) const;

    const Plan& plan_;
    const Job& job_;
    const std::vector<RayEnd>& ends_;
    const std::vector<PathState>& paths_;
    const std::vector<std::uint32_t>& segments_;
    const std::uint64_t first_ray_;
    const bool adds_action_to_time_;
    std::vector<double> offsets_;  ///< Job::path_offsets of the segments.
};

}  // namespace kagero
