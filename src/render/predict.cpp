#include "render/predict.h"

#include "render/camera.h"
#include "render/run.h"

#include <algorithm>

namespace kagero {
namespace {

/// Pixels between the rays that are followed.
constexpr std::uint32_t spacing = 16;
/// Rays of the first pass handed out at a time.
constexpr std::uint32_t chunk = 64;
/// What a ray costs beside its gradients (its start, landing and shading), in gradients: some 100 in a room of checkers, 50
/// against a textured sky. Tiles of one size keep their order whatever it is.
constexpr double gradients_of_a_ray = 80;

/// The pixels that stand for a tile: the middles of squares, or what of them lies inside.
void add_samples(const Plan& plan, const Tile& tile, std::vector<RayStart>& starts) {
    const auto middle = [](std::uint32_t from, std::uint32_t to) { return std::min(from + spacing / 2, (from + to) / 2) + 0.5; };
    for (std::uint32_t y = tile.y0; y < tile.y1; y += spacing)
        for (std::uint32_t x = tile.x0; x < tile.x1; x += spacing)
            starts.push_back(camera_ray(plan, middle(x, tile.x1), middle(y, tile.y1)).start);
}

}  // namespace

void predict_costs(const Plan& plan, WorkList& work, const std::atomic<bool>* stop) {
    std::vector<RayStart> starts;
    std::vector<std::size_t> first;  // of each tile's samples; one more at the end
    for (const Tile& tile : work.tiles) first.push_back(starts.size()), add_samples(plan, tile, starts);
    first.push_back(starts.size());

    Job job = plan.job;
    job.camera = nullptr, job.rays = starts.data();
    WorkList list;
    const auto count = static_cast<std::uint32_t>(starts.size());
    for (std::uint32_t i = 0; i < count; i += chunk) list.tiles.push_back({i, 0, std::min(i + chunk, count), 1});
    std::vector<std::uint32_t> gradients(starts.size());
    Watch watch;
    watch.stop = stop;
    run_tiles(
        plan, job, list, {},
        [&](const Tile& tile, const RayEnd* ends, const RayList&) {
            for (std::uint32_t i = tile.x0; i < tile.x1; ++i) gradients[i] = ends[i - tile.x0].gradients;
        },
        watch);

    for (std::size_t t = 0; t < work.tiles.size(); ++t) {
        double sum = 0;
        for (std::size_t i = first[t]; i < first[t + 1]; ++i) sum += gradients[i] + gradients_of_a_ray;
        const Tile& tile = work.tiles[t];
        const double rays = double(tile.x1 - tile.x0) * double(tile.y1 - tile.y0) * plan.scene.film.spp;
        work.costs[t] = rays * sum / double(first[t + 1] - first[t]);
    }
}

}  // namespace kagero
