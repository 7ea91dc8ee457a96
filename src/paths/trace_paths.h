/// Paths of rays that continue at surfaces, generation by generation.
///
/// Kernels trace rays from their start to their end. The rays of a tile that end on a surface that sends light on
/// become the starts of the next generation. These are grouped by medium, and each group is a list of rays for the
/// kernel of its medium, which fills its packets with them. No tracing loop handles bounces.
#pragma once

#include "appearance/path_state.h"
#include "paths/trace_tile.h"
#include "rays/ray_cell.h"

namespace kagero {

/// The rays of a tile, and the ends of their paths.
struct TracedRays {
    RayList list;  ///< The rays; empty if the kernel generates them, or if the job has a list.
    /// The end of each path, in the coordinates of the space of the scene. Steps, gradients, iterations, queries, λ and
    /// the integrals are sums over the segments; the energy error is the greatest one.
    std::vector<RayEnd> ends;
    std::vector<PathState> paths;  ///< One for each ray; empty if no ray can have continued.
    std::vector<std::uint8_t> traced;  ///< For each ray: 0 if its end is interpolated. Empty: all rays were traced.
    /// Cells whose pixels have no element of `ends` yet. Their colours are computed from the cells, or write_ends in
    /// src/adaptive/write_ends.h sets the elements.
    std::vector<RayCell> cells;
};

/// The work for one generation of rays.
struct GenerationCount {
    std::uint64_t rays = 0, active_lane_steps = 0, issued_lane_steps = 0;
    std::uint64_t nanoseconds = 0;  ///< Processor time for the interactions and the tracing.

    void add(const GenerationCount& other);
};

/// The branch that a ray takes at a mirror or boundary: the stronger one, or a random one with the probability of its
/// share. A diffuse surface sends rays into random directions; with `stronger`, it ends them instead.
enum class BranchChoice { stronger, stronger_or_scattered, sampled };
/// Returns the choice for the rays of a picture: random if a pixel has several rays.
inline BranchChoice branch_choice_of(const Plan& plan) {
    const bool has_samples = plan.description().film.spp > 1 || plan.run.is_one_sample;
    return has_samples ? BranchChoice::sampled : BranchChoice::stronger_or_scattered;
}

/// The work of a tile; entry i of `generations` is that of generation i.
struct PathCounters {
    Counters total{};  ///< Counters::ended counts the ends of paths.
    std::vector<GenerationCount> generations;
};

/// Traces the rays of a tile and follows them through all surfaces that send light on, up to RunConfig::max_bounces.
/// The rays are those of `rays.list`, or, if this list is empty, those of the job's camera or ray list. Random choices
/// depend only on the pixel, the sample and the bounce. The results are meaningless if `cancel` returned true.
void trace_paths(const Plan& plan, const Job& job, const Tile& tile, BranchChoice choice, TracedRays& rays,
                 PathCounters& counters, const CancelToken& cancel = {});

}  // namespace kagero
