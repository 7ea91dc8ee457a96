#include "render/predict.h"

#include "appearance/footprint.h"
#include "pixels/shade_tile.h"
#include "render/operation_count.h"

#include <algorithm>

namespace kagero {
namespace {

/// Distance in pixels between the sample points of a tile, for single rays and for blocks of 2 × 2 rays.
constexpr std::uint32_t spacing_of_rays = 11, spacing_of_blocks = 16;
/// Number of sample rays in one unit of work.
constexpr std::uint32_t rays_per_chunk = 64;
/// Cost of a ray in addition to its steps (start and refinement), and cost of a query, in floating-point operations.
/// They are chosen such that predicted and measured costs of tiles correlate (`kagero profile`).
constexpr double operations_per_ray = 1000, operations_per_query = 450;
/// Cost of one texture lookup in the sky's image, in operations on one lane. It is chosen in the same way.
constexpr double operations_per_lookup = 225;

/// Greatest share of the time limit that the prediction may take.
constexpr double max_time_share = 0.1;

/// Weight of the slowest sample ray in the cost of a tile; the mean of all sample rays has the rest. A packet takes as
/// many steps as its slowest ray, and the rays of a packet differ about half as much as the rays of a whole tile.
constexpr double slowest_ray_weight = 0.5;

/// Sample rays of all tiles, from which the costs are predicted. A sample point has one ray through the centre of a
/// pixel. If the costs depend on footprints on the sky, it has a block of 2 × 2 pixels with one ray each.
class CostSample {
public:
    CostSample(const Plan& plan, const Film& film, const std::vector<Tile>& tiles, const RunControl& control)
        : plan_(plan), tiles_(tiles), operations_(operations_of(plan)), edge_(needs_footprints(plan, film) ? 2 : 1) {
        for (const Tile& tile : tiles) {
            first_.push_back(costs_.size());
            add_points(tile);
        }
        first_.push_back(costs_.size());
        trace(control);
    }
    bool complete() const { return complete_; }
    /// Returns the predicted cost of a tile, in operations.
    double cost_of(std::size_t tile) const {
        const auto begin = costs_.begin() + std::ptrdiff_t(first_[tile]),
                   end = costs_.begin() + std::ptrdiff_t(first_[tile + 1]);
        double steps = 0, slowest = 0, rest = 0;
        for (auto cost = begin; cost != end; ++cost) {
            steps += cost->steps / double(end - begin);
            rest += cost->rest / double(end - begin);
            slowest = std::max(slowest, cost->steps);
        }
        const Tile& t = tiles_[tile];
        return double(t.x1 - t.x0) * double(t.y1 - t.y0) * plan_.description().film.spp *
               (steps + slowest_ray_weight * (slowest - steps) + rest);
    }

private:
    /// Mean cost of a ray, in operations. The steps are separate because a packet runs until its ray with the most
    /// steps has terminated.
    struct Cost {
        double steps = 0, rest = 0;
    };

    /// Adds the sample points of a tile: the centres of squares, which are smaller at the tile's edge.
    void add_points(const Tile& tile) {
        const std::uint32_t spacing = edge_ > 1 ? spacing_of_blocks : spacing_of_rays;
        const auto middle = [&](std::uint32_t from, std::uint32_t to) {
            return std::min(from + spacing / 2, (from + to) / 2) / edge_ * edge_;
        };
        for (std::uint32_t y = tile.y0; y < tile.y1; y += spacing)
            for (std::uint32_t x = tile.x0; x < tile.x1; x += spacing) {
                costs_.emplace_back();
                for (std::uint32_t i = 0; i < edge_ * edge_; ++i)
                    starts_.push_back(
                        camera_ray(plan_, middle(x, tile.x1) + i % edge_ + 0.5, middle(y, tile.y1) + i / edge_ + 0.5)
                            .start);
            }
    }
    void trace(const RunControl& control) {
        Job job = plan_.job();
        job.camera = nullptr;
        job.rays = starts_.data();
        WorkList work;
        const auto count = static_cast<std::uint32_t>(starts_.size());
        for (std::uint32_t i = 0; i < count; i += rays_per_chunk)
            work.tiles.push_back({i, 0, std::min(i + rays_per_chunk, count), 1});
        const std::uint32_t rays_per_point = edge_ * edge_;
        const auto done = [&](const Tile& rays, const RayEnd* ends, const RayList&, const CancelToken&) {
            for (std::uint32_t i = rays.x0; i < rays.x1; i += rays_per_point)
                costs_[i / rays_per_point] = cost_of(ends + (i - rays.x0));
        };
        complete_ = !run_tiles(plan_, job, work, {}, done, control).interrupted;
    }
    /// Returns the mean cost of the rays at one sample point.
    Cost cost_of(const RayEnd* ends) const {
        Cost cost;
        const std::uint32_t rays = edge_ * edge_;
        for (std::uint32_t i = 0; i < rays; ++i) {
            cost.steps += operations_.per_gradient * ends[i].gradients + operations_.per_step * ends[i].steps;
            cost.rest += operations_per_query * ends[i].queries + operations_per_ray;
        }
        if (edge_ > 1) cost.rest += operations_of_lookups(ends);
        return {cost.steps / rays, cost.rest / rays};
    }
    /// Returns the cost of the texture lookups of a block.
    double operations_of_lookups(const RayEnd* ends) const {
        PixelBlock block;
        for (std::uint32_t i = 0; i < edge_ * edge_; ++i) {
            PixelSample& ray = block.rays.emplace_back();
            ray.end = ends + i;
            if (ray.end->status == Status::escaped) ray.sky = sky_view(plan_.scene->space, *ray.end);
            block.film_positions.push_back({double(i % edge_), double(i / edge_)});
        }
        const SkyFootprints footprints = footprints_of(block, plan_.description().film.spp);
        int lookups = 0;
        for (const PixelSample& ray : block.rays) lookups += probes_of(plan_, ray, footprints);
        const double lanes = double(plan_.run.kernel->lanes) / plan_.run.kernel->registers;
        return lanes * operations_per_lookup * lookups;
    }

    const Plan& plan_;
    const std::vector<Tile>& tiles_;
    Operations operations_;
    std::uint32_t edge_;  ///< Edge of a sample point, in pixels: 1 or 2.
    std::vector<RayStart> starts_;
    std::vector<Cost> costs_;         ///< For each sample point.
    std::vector<std::size_t> first_;  ///< Index of the first sample point of each tile, and their total number.
    bool complete_ = false;
};

}  // namespace

void predict_costs(const Plan& plan, const Film& film, WorkList& work, const RunControl& control) {
    RunControl limited;
    limited.stop = control.stop;
    limited.time_limit = max_time_share * control.time_limit;
    const CostSample sample(plan, film, work.tiles, limited);
    if (!sample.complete()) return;
    for (std::size_t t = 0; t < work.tiles.size(); ++t) work.costs[t] = sample.cost_of(t);
}

}  // namespace kagero
