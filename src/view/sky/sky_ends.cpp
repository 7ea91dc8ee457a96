#include "view/sky/sky_ends.h"

#include "render/run.h"

namespace kagero {
namespace {

RayStart start_in_direction(const Plan& plan, const Double3& direction) {
    const CameraRays& camera = plan.view.camera;
    RayStart start = plan.view.solves_each_direction ? plan.scene->space.start(camera.position, direction)
                                                     : ray_in_frame(camera.start, direction).start;
    start.medium = plan.view.medium;
    return start;
}

SkyEnd sky_end_of(const Plan& plan, const RayEnd& end) {
    if (end.status == Status::captured) return {{}, SkyEnd::Kind::captured};
    if (end.status != Status::escaped) return {};
    const SkyView view = sky_view(plan.scene->sources.skies, end);
    const auto& d = view.direction;
    return {{float(d[0]), float(d[1]), float(d[2])},
            view.on_second_sheet ? SkyEnd::Kind::second_sky : SkyEnd::Kind::first_sky};
}

}  // namespace

std::vector<SkyEnd> trace_sky_ends(const Plan& plan, const std::vector<Double3>& directions, std::uint64_t& rays,
                                   double& seconds) {
    constexpr std::uint32_t rays_per_chunk = 256;
    std::vector<SkyEnd> ends(directions.size());
    if (directions.empty()) return ends;
    std::vector<RayStart> starts;
    starts.reserve(directions.size());
    for (const Double3& direction : directions) starts.push_back(start_in_direction(plan, direction));
    Job job = plan.job();
    job.camera = nullptr;
    job.rays = starts.data();
    WorkList work;
    const auto count = static_cast<std::uint32_t>(starts.size());
    for (std::uint32_t i = 0; i < count; i += rays_per_chunk)
        work.tiles.push_back({i, 0, std::min(i + rays_per_chunk, count), 1});
    const auto store = [&](const Tile& tile, const TracedRays& traced, const CancelToken&) {
        for (std::uint32_t i = tile.x0; i < tile.x1; ++i) ends[i] = sky_end_of(plan, traced.ends[i - tile.x0]);
    };
    const RunReport report = run_tiles(plan, job, work, {}, store);
    rays += report.rays;
    seconds += report.seconds;
    return ends;
}

}  // namespace kagero
