#include "render/predict.h"

#include "render/camera.h"
#include "render/list_rays.h"
#include "render/shade_tile.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <numeric>

namespace kagero {
namespace {

/// Pixels between the rays that are followed.
constexpr std::uint32_t spacing = 11;
/// Rays of the first pass handed out at a time.
constexpr std::uint32_t chunk = 64;
/// What a ray costs beside its steps (its start and landing), and what a query costs, in floating-point operations of steps: as the tiles
/// of a room say. Tiles of one size keep their order whatever the first is.
constexpr double operations_of_a_ray = 1000, operations_of_a_query = 300;

/// A packet takes as long as its slowest ray: neighbours differ by about this share of what rays all over a tile do.
constexpr double waiting = 0.2;

/// The pixels that stand for a tile: the middles of squares, or what of them lies inside.
void add_samples(const Plan& plan, const Tile& tile, std::vector<RayStart>& starts) {
    const auto middle = [](std::uint32_t from, std::uint32_t to) { return std::min(from + spacing / 2, (from + to) / 2) + 0.5; };
    for (std::uint32_t y = tile.y0; y < tile.y1; y += spacing)
        for (std::uint32_t x = tile.x0; x < tile.x1; x += spacing)
            starts.push_back(camera_ray(plan, middle(x, tile.x1), middle(y, tile.y1)).start);
}

/// The block of 2 × 2 pixels in the middle of a tile.
Tile middle_of(const Tile& tile) {
    const std::uint32_t x = (tile.x0 + (tile.x1 - tile.x0) / 2) & ~1u, y = (tile.y0 + (tile.y1 - tile.y0) / 2) & ~1u;
    return {x, y, std::min(x + 2, tile.x1), std::min(y + 2, tile.y1)};
}

double operations_of(const Operations& o, const RayEnd& end) {
    return o.per_gradient * end.gradients + o.per_step * end.steps + operations_of_a_query * end.queries + operations_of_a_ray;
}

/// What shading a pixel of a block costs, in seconds, by the clock: twice, for the first time finds everything cold.
double seconds_to_shade(const Plan& plan, const Tile& block, const RayEnd* ends, const RayList& list) {
    Film scratch(2, 2, {"color"});
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 2; ++i) {
        const auto begin = std::chrono::steady_clock::now();
        shade_tile(plan, block, block, ends, list, {}, scratch);
        least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    }
    return least / ((block.x1 - block.x0) * (block.y1 - block.y0));
}

/// The first pass.
class Sample {
public:
    Sample(const Plan& plan, const Film& film, const std::vector<Tile>& tiles, const std::atomic<bool>* stop)
        : plan_(plan), tiles_(tiles),
          operations_(plan.module->operations(plan.job.hamiltonian, plan.job.parameters, plan.job.integrator, plan.job.rescaled)),
          shades_(wants_footprints(plan, film)) {
        for (const Tile& tile : tiles) first_.push_back(starts_.size()), add_samples(plan, tile, starts_);
        first_.push_back(starts_.size());
        operations_of_ray_.resize(starts_.size());
        seconds_.resize(tiles.size());
        trace(stop);
    }
    /// In operations.
    double cost_of(std::size_t tile) const {
        const auto begin = operations_of_ray_.begin();
        const auto first = std::ptrdiff_t(first_[tile]), last = std::ptrdiff_t(first_[tile + 1]);
        const Tile& t = tiles_[tile];
        const double mean = std::accumulate(begin + first, begin + last, 0.0) / double(last - first);
        const double of_ray = mean + waiting * (*std::max_element(begin + first, begin + last) - mean);
        return double(t.x1 - t.x0) * double(t.y1 - t.y0) * (plan_.scene.film.spp * of_ray + operations_per_second_ * seconds_[tile]);
    }

private:
    /// Rays that stand for tiles, a few packets at a time, then the blocks of pixels.
    void trace(const std::atomic<bool>* stop) {
        Job job = plan_.job;
        job.camera = nullptr, job.rays = starts_.data();
        WorkList work;
        const auto count = static_cast<std::uint32_t>(starts_.size());
        for (std::uint32_t i = 0; i < count; i += chunk) work.tiles.push_back({i, 0, std::min(i + chunk, count), 1});
        Watch watch;
        watch.stop = stop;
        const RunReport report = run_tiles(
            plan_, job, work, {},
            [&](const Tile& rays, const RayEnd* ends, const RayList&) {
                for (std::uint32_t i = rays.x0; i < rays.x1; ++i) operations_of_ray_[i] = operations_of(operations_, ends[i - rays.x0]);
            },
            watch);
        double busy = 0;
        for (const ThreadTime& time : report.threads) busy += time.busy;
        // Rays so far apart leave lanes empty, which those of the picture fill.
        const Counters& c = report.counters;
        if (busy > 0 && c.active_lane_steps > 0)
            operations_per_second_ = std::accumulate(operations_of_ray_.begin(), operations_of_ray_.end(), 0.0) / busy *
                                     double(c.issued_lane_steps) / double(c.active_lane_steps);
        if (shades_) shade(watch);
    }
    /// A few blocks at a time, so that their rays fill packets.
    void shade(const Watch& watch) {
        WorkList work;
        const auto tiles = static_cast<std::uint32_t>(tiles_.size());
        constexpr std::uint32_t blocks = chunk / 4;
        for (std::uint32_t t = 0; t < tiles; t += blocks) work.tiles.push_back({t, 0, std::min(t + blocks, tiles), 1});
        const auto list = [&](const Tile& some, RayList& rays) {
            rays.starts.clear(), rays.frequencies.clear();
            for (std::uint32_t t = some.x0; t < some.x1; ++t) {
                const RayList block = rays_of_block(t);
                rays.starts.insert(rays.starts.end(), block.starts.begin(), block.starts.end());
            }
        };
        const auto done = [&](const Tile& some, const RayEnd* ends, const RayList&) {
            for (std::uint32_t t = some.x0; t < some.x1; ++t) {
                const RayList block = rays_of_block(t);
                seconds_[t] = seconds_to_shade(plan_, middle_of(tiles_[t]), ends, block);
                ends += block.starts.size();
            }
        };
        run_tiles(plan_, plan_.job, work, list, done, watch);
    }
    RayList rays_of_block(std::uint32_t tile) const {
        RayList rays;
        list_rays(plan_, middle_of(tiles_[tile]), rays);
        return rays;
    }

    const Plan& plan_;
    const std::vector<Tile>& tiles_;
    Operations operations_;
    bool shades_;  ///< how much of a sky a ray stands for differs by orders of magnitude; all else costs much the same
    std::vector<RayStart> starts_;
    std::vector<std::size_t> first_;  ///< of each tile's rays; one more at the end
    std::vector<double> operations_of_ray_;
    std::vector<double> seconds_;     ///< to shade a pixel of each tile
    double operations_per_second_ = 0;
};

}  // namespace

void predict_costs(const Plan& plan, const Film& film, WorkList& work, const std::atomic<bool>* stop) {
    const Sample sample(plan, film, work.tiles, stop);
    for (std::size_t t = 0; t < work.tiles.size(); ++t) work.costs[t] = sample.cost_of(t);
}

}  // namespace kagero
