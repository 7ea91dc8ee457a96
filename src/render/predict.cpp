#include "render/predict.h"

#include "appearance/footprint.h"
#include "pixels/shade_tile.h"
#include "render/operation_count.h"

#include <algorithm>

namespace kagero {
namespace {

/// Pixels between the places that stand for a tile, of one ray and of a block of them.
constexpr std::uint32_t spacing_of_rays = 11, spacing_of_blocks = 16;
/// Rays of the first pass handed out at a time.
constexpr std::uint32_t rays_at_a_time = 64;
/// What a ray costs beside its steps (its start and landing), and what a query costs, in floating-point operations of
/// steps: chosen so that predicted and measured costs of tiles correlate (`kagero profile`). Tiles of one size keep
/// their order whatever the first is.
constexpr double operations_of_a_ray = 1000, operations_of_a_query = 450;
/// What a place of the sky's image costs, in the time of operations on one lane: chosen likewise.
constexpr double operations_of_a_probe = 225;

/// What the first pass may take of the time there is.
constexpr double most_of_the_time = 0.1;

/// A packet takes as many steps as its slowest ray: neighbours differ by about this share of what rays all over a tile
/// do.
constexpr double waiting = 0.5;

/// The first pass. At each place it follows the ray in the middle of a pixel, or, where it matters how much of a sky a
/// ray stands for, those of a block of 2 × 2 pixels.
class Sample {
public:
    Sample(const Plan& plan, const Film& film, const std::vector<Tile>& tiles, const Watch& watch)
        : plan_(plan), tiles_(tiles), operations_(operations_of(plan)), edge_(wants_footprints(plan, film) ? 2 : 1) {
        for (const Tile& tile : tiles) first_.push_back(costs_.size()), add_places(tile);
        first_.push_back(costs_.size());
        trace(watch);
    }
    bool complete() const { return complete_; }
    /// In operations.
    double cost_of(std::size_t tile) const {
        const auto begin = costs_.begin() + std::ptrdiff_t(first_[tile]),
                   end = costs_.begin() + std::ptrdiff_t(first_[tile + 1]);
        double steps = 0, slowest = 0, rest = 0;
        for (auto cost = begin; cost != end; ++cost)
            steps += cost->steps / double(end - begin), rest += cost->rest / double(end - begin),
                slowest = std::max(slowest, cost->steps);
        const Tile& t = tiles_[tile];
        return double(t.x1 - t.x0) * double(t.y1 - t.y0) * plan_.description().film.spp *
               (steps + waiting * (slowest - steps) + rest);
    }

private:
    /// Of a ray, in operations: its steps, and what no other ray has to wait for.
    struct Cost {
        double steps = 0, rest = 0;
    };

    /// The middles of squares, or what of them lies inside.
    void add_places(const Tile& tile) {
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
    void trace(const Watch& watch) {
        Job job = plan_.job();
        job.camera = nullptr, job.rays = starts_.data();
        WorkList work;
        const auto count = static_cast<std::uint32_t>(starts_.size());
        for (std::uint32_t i = 0; i < count; i += rays_at_a_time)
            work.tiles.push_back({i, 0, std::min(i + rays_at_a_time, count), 1});
        const std::uint32_t together = edge_ * edge_;
        const auto done = [&](const Tile& rays, const RayEnd* ends, const RayList&, const Halt&) {
            for (std::uint32_t i = rays.x0; i < rays.x1; i += together)
                costs_[i / together] = cost_of(ends + (i - rays.x0));
        };
        complete_ = !run_tiles(plan_, job, work, {}, done, watch).interrupted;
    }
    /// Of the rays at one place.
    Cost cost_of(const RayEnd* ends) const {
        Cost cost;
        const std::uint32_t rays = edge_ * edge_;
        for (std::uint32_t i = 0; i < rays; ++i) {
            cost.steps += operations_.per_gradient * ends[i].gradients + operations_.per_step * ends[i].steps;
            cost.rest += operations_of_a_query * ends[i].queries + operations_of_a_ray;
        }
        if (edge_ > 1) cost.rest += operations_of_the_sky(ends);
        return {cost.steps / rays, cost.rest / rays};
    }
    /// To colour the rays of a block.
    double operations_of_the_sky(const RayEnd* ends) const {
        PixelBlock block;
        for (std::uint32_t i = 0; i < edge_ * edge_; ++i) {
            PixelSample& ray = block.rays.emplace_back();
            ray.end = ends + i;
            if (ray.end->status == Status::escaped) ray.sky = sky_view(plan_.scene->space, *ray.end);
            block.places.push_back({double(i % edge_), double(i / edge_)});
        }
        const SkyFootprints footprints = footprints_of(block, plan_.description().film.spp);
        int probes = 0;
        for (const PixelSample& ray : block.rays) probes += probes_of(plan_, ray, footprints);
        const double lanes = double(plan_.run.kernel->lanes) / plan_.run.kernel->registers;
        return lanes * operations_of_a_probe * probes;
    }

    const Plan& plan_;
    const std::vector<Tile>& tiles_;
    Operations operations_;
    std::uint32_t edge_;  ///< pixels of a place along its sides
    std::vector<RayStart> starts_;
    std::vector<Cost> costs_;         ///< by places
    std::vector<std::size_t> first_;  ///< of each tile's places; one more at the end
    bool complete_ = false;
};

}  // namespace

void predict_costs(const Plan& plan, const Film& film, WorkList& work, const Watch& watch) {
    Watch own;
    own.stop = watch.stop, own.time_limit = most_of_the_time * watch.time_limit;
    const Sample sample(plan, film, work.tiles, own);
    if (!sample.complete()) return;
    for (std::size_t t = 0; t < work.tiles.size(); ++t) work.costs[t] = sample.cost_of(t);
}

}  // namespace kagero
