#include "render/predict.h"

#include "render/camera.h"
#include "render/list_rays.h"
#include "render/operation_count.h"
#include "render/shade_tile.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <numeric>
#include <set>

namespace kagero {
namespace {

/// Pixels between the rays that are followed.
constexpr std::uint32_t spacing = 11;
/// Rays of the first pass handed out at a time.
constexpr std::uint32_t rays_at_a_time = 64;
/// What a ray costs beside its steps (its start and landing), and what a query costs, in floating-point operations of steps: as the tiles
/// of a room and of a mirage say. Tiles of one size keep their order whatever the first is.
constexpr double operations_of_a_ray = 1000, operations_of_a_query = 400;

/// What the first pass may take of the time there is.
constexpr double most_of_the_time = 0.1;

/// A packet takes as long as its slowest ray: neighbours differ by about this share of what rays all over a tile do.
constexpr double waiting = 0.4;

/// The pixels that stand for a tile: the middles of squares, or what of them lies inside.
void add_samples(const Plan& plan, const Tile& tile, std::vector<RayStart>& starts) {
    const auto middle = [](std::uint32_t from, std::uint32_t to) { return std::min(from + spacing / 2, (from + to) / 2) + 0.5; };
    for (std::uint32_t y = tile.y0; y < tile.y1; y += spacing)
        for (std::uint32_t x = tile.x0; x < tile.x1; x += spacing)
            starts.push_back(camera_ray(plan, middle(x, tile.x1), middle(y, tile.y1)).start);
}

/// The block of 2 × 2 pixels in a tile that lies at these quarters of its sides.
Tile block_at(const Tile& tile, std::uint32_t right, std::uint32_t down) {
    const std::uint32_t x = (tile.x0 + (tile.x1 - tile.x0) * right / 4) & ~1u, y = (tile.y0 + (tile.y1 - tile.y0) * down / 4) & ~1u;
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
    Sample(const Plan& plan, const Film& film, const std::vector<Tile>& tiles, const Watch& watch)
        : plan_(plan), tiles_(tiles),
          operations_(operations_of(plan)),
          shades_(wants_footprints(plan, film)) {
        for (const Tile& tile : tiles) first_.push_back(starts_.size()), add_samples(plan, tile, starts_);
        first_.push_back(starts_.size());
        operations_of_ray_.resize(starts_.size());
        seconds_.resize(tiles.size());
        trace(watch);
    }
    bool complete() const { return complete_; }
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
    void trace(const Watch& watch) {
        Job job = plan_.job;
        job.camera = nullptr, job.rays = starts_.data();
        WorkList work;
        const auto count = static_cast<std::uint32_t>(starts_.size());
        for (std::uint32_t i = 0; i < count; i += rays_at_a_time) work.tiles.push_back({i, 0, std::min(i + rays_at_a_time, count), 1});
        const RunReport report = run_tiles(
            plan_, job, work, {},
            [&](const Tile& rays, const RayEnd* ends, const RayList&) {
                for (std::uint32_t i = rays.x0; i < rays.x1; ++i) operations_of_ray_[i] = operations_of(operations_, ends[i - rays.x0]);
            },
            watch);
        complete_ = !report.interrupted;
        if (!complete_) return;
        double busy = 0;
        for (const ThreadTime& time : report.threads) busy += time.busy;
        // Rays so far apart leave lanes empty, which those of the picture fill.
        const Counters& c = report.counters;
        if (busy > 0 && c.active_lane_steps > 0)
            operations_per_second_ = std::accumulate(operations_of_ray_.begin(), operations_of_ray_.end(), 0.0) / busy *
                                     double(c.issued_lane_steps) / double(c.active_lane_steps);
        if (shades_) shade(watch);
    }
    /// The middle of every tile; and where that is dear, or is next door, four blocks more: around a shadow it changes within a tile.
    void shade(const Watch& watch) {
        std::vector<Block> middles, more;
        for (std::uint32_t t = 0; t < tiles_.size(); ++t) middles.push_back({t, block_at(tiles_[t], 2, 2)});
        for (const auto& [tile, seconds] : timed(middles, watch)) seconds_[tile] = seconds;
        const std::vector<std::uint32_t> dear = dear_tiles();
        for (const std::uint32_t t : dear)
            for (const std::uint32_t down : {1, 3})
                for (const std::uint32_t right : {1, 3}) more.push_back({t, block_at(tiles_[t], right, down)});
        const auto seconds = timed(more, watch);
        for (const auto& [tile, s] : seconds) seconds_[tile] += s;
        for (const std::uint32_t t : dear) seconds_[t] /= 5;
    }
    std::vector<std::uint32_t> dear_tiles() const {
        std::vector<double> sorted = seconds_;
        std::nth_element(sorted.begin(), sorted.begin() + std::ptrdiff_t(sorted.size() / 2), sorted.end());
        const double usual = sorted[sorted.size() / 2];
        const std::uint32_t side = tiles_[0].x1 - tiles_[0].x0;
        std::set<std::pair<std::uint32_t, std::uint32_t>> around;
        for (std::size_t t = 0; t < tiles_.size(); ++t) {
            if (!(seconds_[t] > 1.5 * usual)) continue;
            const std::uint32_t x = tiles_[t].x0 / side, y = tiles_[t].y0 / side;
            for (const std::uint32_t dy : {0, 1, 2})
                for (const std::uint32_t dx : {0, 1, 2}) around.insert({x + dx, y + dy});
        }
        std::vector<std::uint32_t> dear;
        for (std::uint32_t t = 0; t < tiles_.size(); ++t)
            if (around.contains({tiles_[t].x0 / side + 1, tiles_[t].y0 / side + 1})) dear.push_back(t);
        return dear;
    }
    struct Block {
        std::uint32_t tile;
        Tile pixels;
    };
    struct BlockTime {
        std::uint32_t tile;
        double seconds;  ///< of a pixel
    };
    /// Traces and shades a few blocks at a time, so that their rays fill packets.
    std::vector<BlockTime> timed(const std::vector<Block>& blocks, const Watch& watch) const {
        WorkList work;
        const auto count = static_cast<std::uint32_t>(blocks.size());
        constexpr std::uint32_t together = rays_at_a_time / 4;
        for (std::uint32_t i = 0; i < count; i += together) work.tiles.push_back({i, 0, std::min(i + together, count), 1});
        std::vector<BlockTime> times(blocks.size());
        const auto list = [&](const Tile& some, RayList& rays) {
            rays.starts.clear(), rays.frequencies.clear();
            for (std::uint32_t i = some.x0; i < some.x1; ++i) {
                const RayList block = rays_of(blocks[i]);
                rays.starts.insert(rays.starts.end(), block.starts.begin(), block.starts.end());
            }
        };
        const auto done = [&](const Tile& some, const RayEnd* ends, const RayList&) {
            for (std::uint32_t i = some.x0; i < some.x1; ++i) {
                const RayList block = rays_of(blocks[i]);
                times[i] = {blocks[i].tile, seconds_to_shade(plan_, blocks[i].pixels, ends, block)};
                ends += block.starts.size();
            }
        };
        run_tiles(plan_, plan_.job, work, list, done, watch);
        return times;
    }
    RayList rays_of(const Block& block) const {
        RayList rays;
        list_rays(plan_, block.pixels, rays);
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
