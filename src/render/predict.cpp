#include "render/predict.h"

#include "appearance/footprint.h"
#include "pixels/shade_tile.h"
#include "render/operation_count.h"

#include <algorithm>

namespace kagero {
namespace {

/// Distance in pixels between the sample points of a tile, for single rays and for blocks of 2 × 2 rays.
constexpr std::uint32_t spacing_of_rays = 11, spacing_of_blocks = 16;
/// Number of sample rays in one tile of the WorkList.
constexpr std::uint32_t sample_rays_per_chunk = 64;
/// Cost of a ray in addition to its steps (start and refinement), and cost of a query, in floating-point operations.
/// These constants and `vector_operations_per_probe` are chosen such that predicted and measured costs of tiles
/// correlate (`kagero profile`).
constexpr double operations_per_ray = 1000, operations_per_query = 450;
/// Cost of one probe of the sky's image, in SIMD instructions. The code is scalar; in the same time, a kernel does this
/// number of operations in each lane of a register.
constexpr double vector_operations_per_probe = 225;

/// Greatest share of the time limit that the prediction may take.
constexpr double max_time_share = 0.1;

/// Weight w of the sample ray with the greatest cost of steps. The predicted cost of steps is w times this cost plus
/// (1 − w) times the mean cost. A packet takes as many steps as its slowest ray, and the rays of a packet differ about
/// half as much as the rays of a whole tile.
constexpr double slowest_ray_weight = 0.5;

/// Sample rays of all tiles, from which the costs are predicted. A sample point has one ray through the centre of a
/// pixel. If the costs depend on footprints on the sky, it has a block of 2 × 2 pixels with one ray each.
class CostSample {
public:
    CostSample(const Plan& plan, const Film& film, const std::vector<Tile>& tiles, const RunControl& control)
        : plan_(plan), tiles_(tiles), operations_(operations_of(plan)),
          point_edge_(needs_footprints(plan, film) ? 2 : 1), rays_per_point_(point_edge_ * point_edge_) {
        for (const Tile& tile : tiles) {
            first_point_.push_back(costs_.size());
            add_points(tile);
        }
        first_point_.push_back(costs_.size());
        trace(control);
    }
    bool complete() const { return complete_; }
    /// Returns the predicted cost of a tile, in operations.
    double cost_of_tile(std::size_t tile) const {
        const auto begin = costs_.begin() + std::ptrdiff_t(first_point_[tile]),
                   end = costs_.begin() + std::ptrdiff_t(first_point_[tile + 1]);
        double mean_steps = 0, greatest_steps = 0, mean_other = 0;
        for (auto cost = begin; cost != end; ++cost) {
            mean_steps += cost->steps / double(end - begin);
            mean_other += cost->other / double(end - begin);
            greatest_steps = std::max(greatest_steps, cost->steps);
        }
        const Tile& t = tiles_[tile];
        return double(t.x1 - t.x0) * double(t.y1 - t.y0) * plan_.description().film.spp *
               (mean_steps + slowest_ray_weight * (greatest_steps - mean_steps) + mean_other);
    }

private:
    /// Mean cost of the rays at one sample point, in operations. The costs of steps are separate because a packet runs
    /// until its ray with the most steps has terminated.
    struct Cost {
        double steps = 0;
        double other = 0;  ///< Start, refinement, queries and probes.
    };

    /// Adds the sample points of a tile: the centres of squares, which are smaller at the tile's edge.
    void add_points(const Tile& tile) {
        const std::uint32_t spacing = point_edge_ > 1 ? spacing_of_blocks : spacing_of_rays;
        // Returns the first pixel of a sample point, along one axis, in the square that begins at pixel `begin` of a
        // tile that ends at pixel `tile_end`. Blocks of 2 × 2 pixels begin at even pixels, like those of the film.
        const auto middle = [&](std::uint32_t begin, std::uint32_t tile_end) {
            return std::min(begin + spacing / 2, (begin + tile_end) / 2) / point_edge_ * point_edge_;
        };
        for (std::uint32_t y = tile.y0; y < tile.y1; y += spacing)
            for (std::uint32_t x = tile.x0; x < tile.x1; x += spacing) {
                costs_.emplace_back();
                for (std::uint32_t i = 0; i < rays_per_point_; ++i)
                    starts_.push_back(camera_ray(plan_, middle(x, tile.x1) + i % point_edge_ + 0.5,
                                                 middle(y, tile.y1) + i / point_edge_ + 0.5)
                                          .start);
            }
    }
    void trace(const RunControl& control) {
        Job job = plan_.job();
        job.camera = nullptr;
        job.rays = starts_.data();
        WorkList work;
        const auto count = static_cast<std::uint32_t>(starts_.size());
        for (std::uint32_t i = 0; i < count; i += sample_rays_per_chunk)
            work.tiles.push_back({i, 0, std::min(i + sample_rays_per_chunk, count), 1});
        const auto store_costs = [&](const Tile& rays, const TracedRays& traced, const CancelToken&) {
            for (std::uint32_t i = rays.x0; i < rays.x1; i += rays_per_point_)
                costs_[i / rays_per_point_] = cost_of_point(&traced.ends[i - rays.x0]);
        };
        complete_ = !run_tiles(plan_, job, work, {}, store_costs, control).interrupted;
    }
    /// Returns the mean cost of the rays at one sample point.
    Cost cost_of_point(const RayEnd* ends) const {
        Cost cost;
        for (std::uint32_t i = 0; i < rays_per_point_; ++i) {
            cost.steps += operations_.per_gradient * ends[i].gradients + operations_.per_step * ends[i].steps;
            cost.other += operations_per_query * ends[i].queries + operations_per_ray;
        }
        if (point_edge_ > 1) cost.other += operations_of_probes(ends);
        return {cost.steps / rays_per_point_, cost.other / rays_per_point_};
    }
    /// Returns the cost of the probes of a block of 2 × 2 rays.
    double operations_of_probes(const RayEnd* ends) const {
        PixelBlock block;
        for (std::uint32_t i = 0; i < rays_per_point_; ++i) {
            PixelSample& ray = block.rays.emplace_back();
            ray.end = ends + i;
            if (ray.end->status == Status::escaped) ray.sky = sky_view(plan_.scene->sources.skies, *ray.end);
            block.film_positions.push_back({double(i % point_edge_), double(i / point_edge_)});
        }
        const SkyFootprints footprints = footprints_of(block, plan_.description().film.spp);
        int probes = 0;
        for (const PixelSample& ray : block.rays) {
            if (ray.end->status != Status::escaped) continue;
            const Footprint& footprint = ray.sky.on_second_sheet ? footprints.second_sheet : footprints.first_sheet;
            probes += plan_.scene->paints->sky_filter(ray.sky.on_second_sheet, footprint).probes.count;
        }
        const double lanes_per_register = double(plan_.run.kernel->lanes) / plan_.run.kernel->registers;
        return lanes_per_register * vector_operations_per_probe * probes;
    }

    const Plan& plan_;
    const std::vector<Tile>& tiles_;
    Operations operations_;
    std::uint32_t point_edge_;  ///< Edge of the block of pixels of a sample point: 1 or 2 pixels.
    std::uint32_t rays_per_point_;
    std::vector<RayStart> starts_;          ///< The rays of all sample points.
    std::vector<Cost> costs_;               ///< For each sample point.
    std::vector<std::size_t> first_point_;  ///< Index of each tile's first sample point; last, the number of points.
    bool complete_ = false;                 ///< True if all sample rays were traced.
};

}  // namespace

void predict_costs(const Plan& plan, const Film& film, WorkList& work, const RunControl& control) {
    RunControl limited_control;
    limited_control.stop = control.stop;
    limited_control.time_limit = max_time_share * control.time_limit;
    const CostSample sample(plan, film, work.tiles, limited_control);
    if (!sample.complete()) return;
    for (std::size_t t = 0; t < work.tiles.size(); ++t) work.costs[t] = sample.cost_of_tile(t);
}

}  // namespace kagero
