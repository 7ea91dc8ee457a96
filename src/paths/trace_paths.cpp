#include "paths/trace_paths.h"

#include "paths/circling_rays.h"
#include "paths/close_hits.h"
#include "paths/medium_indices.h"
#include "paths/segments.h"
#include "rays/pixel_rays.h"
#include "scene/vector3.h"

#include <time.h>

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// Returns the processor time of this thread. Unlike the time of the clock, it does not depend on other programs.
std::uint64_t thread_nanoseconds() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return std::uint64_t(now.tv_sec) * 1'000'000'000 + std::uint64_t(now.tv_nsec);
}

/// The generations of the rays of one tile.
class Generations {
public:
    Generations(const Plan& plan, const Job& job, const Tile& tile, BranchChoice choice, TracedRays& rays,
                PathCounters& counters, const CancelToken& cancel)
        : plan_(plan), job_(job), tile_(tile), choice_(choice), rays_(rays), counters_(counters), cancel_(cancel),
          job_medium_(job.rays ? 0 : plan.view.medium), next_(plan.media.size() + 1), traced_(plan.media.size() + 1),
          solver_(plan), frames_(plan), scatterer_(plan), pixel_rays_(plan.description()) {}

    /// Traces the first generation.
    void start() {
        const std::uint64_t begin = thread_nanoseconds();
        const Counters before = counters_.total;
        const RayStart* starts = rays_.list.starts.empty() ? job_.rays : rays_.list.starts.data();
        if (!starts || all_start_in_space(starts)) {
            const std::uint32_t medium = starts ? 0 : job_medium_;
            trace_tile(*plan_.medium(medium).run.kernel, job_, tile_, rays_.list, rays_.ends, counters_.total);
            begin_paths(medium);
            for (std::uint32_t i = 0; i < rays_.ends.size(); ++i) {
                const double* q = starts ? starts[i + first_start()].q : job_.camera->start.position;
                std::copy_n(q, 3, origins_[i].begin());
                traced_[medium].push_back(i);
            }
            count(0, rays_.ends.size(), before, begin);
            return;
        }
        rays_.ends.assign(count_of_rays(), RayEnd{});
        begin_paths(0);
        for (std::uint32_t i = 0; i < rays_.ends.size(); ++i) {
            const RayStart& start = starts[first_start() + i];
            rays_.paths[i].medium = start.medium;
            next_[start.medium].add(i, start);
        }
        trace_segments(before, begin, 0);
    }
    /// Traces further generations until no ray continues.
    void follow() {
        for (std::size_t generation = 1; !cancel_(); ++generation) {
            const std::uint64_t begin = thread_nanoseconds();
            const Counters before = counters_.total;
            if (!prepare()) break;
            trace_segments(before, begin, generation);
        }
        for (std::size_t i = 0; i < rays_.ends.size(); ++i) to_space(plan_, rays_.paths[i].medium, rays_.ends[i].q);
    }

private:
    std::size_t count_of_rays() const {
        return rays_.list.starts.empty() ? tile_.x1 - tile_.x0 : rays_.list.starts.size();
    }
    /// Returns the index of the tile's first ray in its list.
    std::size_t first_start() const { return rays_.list.starts.empty() ? tile_.x0 : 0; }
    bool all_start_in_space(const RayStart* starts) const {
        if (plan_.media.empty()) return true;
        const RayStart* const first = starts + first_start();
        return std::all_of(first, first + count_of_rays(), [](const RayStart& start) { return start.medium == 0; });
    }
    void begin_paths(std::uint32_t medium) {
        rays_.paths.assign(rays_.ends.size(), PathState{});
        origins_.resize(rays_.ends.size());
        indices_.reset(plan_, rays_.ends.size());
        for (PathState& path : rays_.paths) path.medium = medium;
    }
    /// Adds the work of a generation since `begin`, when the counters were `before`.
    void count(std::size_t generation, std::size_t rays, const Counters& before, std::uint64_t begin) {
        if (counters_.generations.size() <= generation) counters_.generations.resize(generation + 1);
        counters_.generations[generation].add({rays, counters_.total.active_lane_steps - before.active_lane_steps,
                                               counters_.total.issued_lane_steps - before.issued_lane_steps,
                                               thread_nanoseconds() - begin});
    }

    /// Makes the segments of the next generation from the rays that have just been traced. Returns false if no ray
    /// continues.
    bool prepare();
    /// Continues the rays of `continuing_`, whose hits are in `hits_`.
    void continue_rays();
    void continue_ray(std::uint32_t ray, const SurfaceInteraction& interaction);
    /// Adds the light that a surface emits to a path. Returns the colour of the surface.
    DiffuseColor add_emission(std::uint32_t ray, const DiffusePoint& point);
    /// Adds the light that a diffuse surface emits, and adds the ray to those that are scattered unless roulette ends
    /// it.
    void meet_diffuse_surface(std::uint32_t ray, const SurfaceInteraction& interaction);
    /// Continues the rays of `scattered_` in random directions.
    void scatter_rays();
    void scatter(std::uint32_t ray, const DiffusePoint& point, const SurfaceFrame& frame);
    /// Returns true if Russian roulette ends a path at a diffuse surface. Otherwise, divides its weight by the
    /// probability of its survival, so that the mean of the light does not change.
    bool ends_by_roulette(const PixelRay& ray, PathState& path) const;
    PixelRay pixel_ray_of(std::uint32_t ray) const;
    static DiffusePoint point_at_end(std::uint32_t medium, const RayEnd& end) {
        return {medium, end.surface, end.primitive, {end.q[0], end.q[1], end.q[2]}, {}, {}, end.pt};
    }
    bool ends_ray(const ObjectDescription& object) const {
        return !sends_light_on(object) || (object.material == Material::diffuse && choice_ == BranchChoice::stronger);
    }
    const Branch* choose(std::uint32_t ray, const SurfaceInteraction& interaction) const;
    /// Traces the segments of all media, and appends them to their paths.
    void trace_segments(const Counters& before, std::uint64_t begin, std::size_t generation);
    void trace_group(std::uint32_t medium);
    /// Ends the path of a ray that has hit a surface or left its medium.
    void end_path(std::uint32_t ray, Status status, Failure failure) {
        RayEnd& end = rays_.ends[ray];
        --counters_.total.ended[static_cast<int>(end.status)];
        ++counters_.total.ended[static_cast<int>(status)];
        end.status = status;
        end.failure = failure;
    }

    const Plan& plan_;
    const Job& job_;
    const Tile& tile_;
    const BranchChoice choice_;
    TracedRays& rays_;
    PathCounters& counters_;
    const CancelToken& cancel_;
    const std::uint32_t job_medium_;  ///< The medium whose plan has made the job: that of the camera, or the space.
    std::vector<Segments> next_;      ///< Segments of the next generation, by medium.
    std::vector<std::vector<std::uint32_t>> traced_;  ///< Rays whose last segment was in this medium, by medium.
    std::vector<Double3> origins_;  ///< Start of the last segment of each ray, in the coordinates of its medium.
    std::vector<std::uint32_t> continuing_;
    std::vector<RayAtSurface> hits_;
    InteractionSolver solver_;
    std::vector<std::uint32_t> scattered_;      ///< Rays at diffuse surfaces,
    std::vector<DiffusePoint> scatter_points_;  ///< and their points there.
    SurfaceFrames frames_;
    Scatterer scatterer_;
    const PixelRays pixel_rays_;
    MediumIndices indices_;
    std::vector<RayEnd> segment_ends_;
};

bool Generations::prepare() {
    constexpr std::size_t hits_per_batch = 64;  // fills packets, and fits into the first-level cache
    const std::vector<ObjectDescription>& objects = plan_.description().objects;
    for (std::uint32_t medium = 0; medium < traced_.size(); ++medium) {
        for (const std::uint32_t ray : traced_[medium]) {
            RayEnd& end = rays_.ends[ray];
            order_close_surfaces(plan_, medium, origins_[ray], end);
            if (end.status == Status::escaped && medium != 0) end_path(ray, Status::failed, Failure::left_medium);
            if (!plan_.run.max_bounces || end.status != Status::hit || ends_ray(objects[end.surface])) continue;
            if (rays_.paths[ray].bounces == *plan_.run.max_bounces) {
                if (objects[end.surface].material == Material::diffuse || objects[end.surface].emission)
                    add_emission(ray, point_at_end(medium, end));
                rays_.ends[ray].cut_off = true;
                end_path(ray, Status::step_limit, Failure::none);
                continue;
            }
            continuing_.push_back(ray);
            hits_.push_back({medium, &end, origins_[ray]});
            if (hits_.size() == hits_per_batch) continue_rays();
        }
        traced_[medium].clear();
    }
    continue_rays();
    return std::any_of(next_.begin(), next_.end(), [](const Segments& segments) { return !segments.rays.empty(); });
}

void Generations::continue_rays() {
    const std::span<const SurfaceInteraction> interactions = solver_.solve(hits_);
    for (std::size_t i = 0; i < continuing_.size(); ++i) continue_ray(continuing_[i], interactions[i]);
    scatter_rays();
    continuing_.clear();
    hits_.clear();
}

const Branch* Generations::choose(std::uint32_t ray, const SurfaceInteraction& interaction) const {
    if (choice_ != BranchChoice::sampled) return interaction.stronger();
    const PixelRay member = pixel_ray_of(ray);
    return interaction.sampled(sample_number(member.x, member.y, member.index, member.seed, rays_.paths[ray].bounces));
}

PixelRay Generations::pixel_ray_of(std::uint32_t ray) const {
    const std::uint32_t spp = plan_.description().film.spp, pixel = ray / spp, width = tile_.x1 - tile_.x0;
    return pixel_rays_.ray(tile_.x0 + pixel % width, tile_.y0 + pixel / width, ray % spp);
}

bool Generations::ends_by_roulette(const PixelRay& ray, PathState& path) const {
    constexpr std::uint32_t certain_bounces = 3;  // short paths carry most of the light, and are always followed
    const double greatest = std::ranges::max(path.weight);
    if (!(greatest > 0)) return true;
    if (path.bounces < certain_bounces || greatest >= 1) return false;
    if (sample_number(ray, RandomChoice::roulette, path.bounces) >= greatest) return true;
    path.weight = scaled(path.weight, 1 / greatest);
    return false;
}

DiffuseColor Generations::add_emission(std::uint32_t ray, const DiffusePoint& point) {
    const RayEnd& end = rays_.ends[ray];
    PathState& path = rays_.paths[ray];
    const DiffuseColor color = diffuse_color(plan_, point, {end.v[0], end.v[1], end.v[2]});
    for (std::size_t k = 0; k < 3; ++k) path.light[k] += path.weight[k] * color.emission[k];
    return color;
}

void Generations::meet_diffuse_surface(std::uint32_t ray, const SurfaceInteraction& interaction) {
    DiffusePoint point = *interaction.diffuse;
    PathState& path = rays_.paths[ray];
    const DiffuseColor color = add_emission(ray, point);
    for (std::size_t k = 0; k < 3; ++k) path.weight[k] *= color.albedo[k];
    if (ends_by_roulette(pixel_ray_of(ray), path)) return;
    path.frequency *= interaction.frequency;
    point.albedo = std::ranges::max(color.albedo);
    scattered_.push_back(ray);
    scatter_points_.push_back(point);
}

void Generations::scatter_rays() {
    const std::span<const SurfaceFrame> frames = frames_.at(scatter_points_);
    for (std::size_t i = 0; i < scattered_.size(); ++i) scatter(scattered_[i], scatter_points_[i], frames[i]);
    scattered_.clear();
    scatter_points_.clear();
}

void Generations::scatter(std::uint32_t ray, const DiffusePoint& point, const SurfaceFrame& frame) {
    if (!frame.exists()) return end_path(ray, Status::failed, Failure::no_continuation);
    PathState& path = rays_.paths[ray];
    const ScatteredDirection scattered = scatterer_.scatter(point, frame, pixel_ray_of(ray), path);
    path.weight = scaled(path.weight, scattered.factor);
    if (!(scattered.factor > 0)) return;  // a direction toward a light, below the horizon
    const RayStart start = frame.start_along(scattered.direction);
    if (start.failure != Failure::none) return end_path(ray, Status::failed, Failure::no_continuation);
    ++path.scatterings;
    ++path.bounces;
    --counters_.total.ended[static_cast<int>(Status::hit)];
    next_[point.medium].add(ray, start);
    next_[point.medium].has_scattered_rays = true;
}

void Generations::continue_ray(std::uint32_t ray, const SurfaceInteraction& interaction) {
    if (interaction.diffuse) return meet_diffuse_surface(ray, interaction);
    const Branch* branch = choose(ray, interaction);
    if (interaction.leaves_medium) return end_path(ray, Status::failed, Failure::left_medium);
    if (!branch) return end_path(ray, Status::failed, Failure::no_continuation);
    const RayEnd& end = rays_.ends[ray];
    PathState& path = rays_.paths[ray];
    const double share = choice_ == BranchChoice::sampled ? 1 : branch->share;
    const bool is_transmitted = interaction.transmitted && branch == &*interaction.transmitted;
    const double radiance = is_transmitted ? indices_.radiance_ratio(ray, path.medium, interaction) : branch->radiance;
    const ObjectDescription& object = plan_.description().objects[end.surface];
    const Double3 tint = object.emission ? add_emission(ray, point_at_end(path.medium, end)).albedo : object.tint;
    for (std::size_t k = 0; k < 3; ++k) path.weight[k] *= share * radiance * tint[k];
    path.frequency *= interaction.frequency;
    path.surfaces = (path.surfaces ^ (2 * std::uint64_t{end.surface} + is_transmitted + 1)) * 0x9e3779b97f4a7c15u;
    ++path.bounces;
    path.medium = branch->medium;
    --counters_.total.ended[static_cast<int>(Status::hit)];
    next_[branch->medium].add(ray, start_of(plan_, *branch));
}

void Generations::trace_segments(const Counters& before, std::uint64_t begin, std::size_t generation) {
    std::size_t rays = 0;
    for (std::uint32_t medium = 0; medium < next_.size() && !cancel_(); ++medium) {
        rays += next_[medium].rays.size();
        if (!next_[medium].rays.empty()) trace_group(medium);
        next_[medium].clear();
    }
    count(generation, rays, before, begin);
}

void Generations::trace_group(std::uint32_t medium) {
    const Plan& plan = plan_.medium(medium);
    Segments& segments = next_[medium];
    if (segments.has_scattered_rays) segments.group_by_octant();
    Job job = medium == job_medium_ ? job_ : plan.job();
    // Rays that come from a surface differ more than those of a camera, so idle lanes get new rays.
    job.refill = plan.run.refill != Refill::off;
    job.outputs = job_.outputs;
    // In a medium without p_t, light takes the time of its optical path length, and rays are followed backward.
    const bool adds_action_to_time = (job.outputs & output_time) && null_ray_sign(*plan.scene) == 0;
    if (adds_action_to_time) job.outputs = (job.outputs & ~output_time) | output_action;
    job.timed = job_.timed;
    cancel_.install(job);
    PathPoints points(plan_, job_, rays_.ends, rays_.paths, segments.rays, tile_.x0, adds_action_to_time);
    points.install(job);
    trace_tile(*plan.run.kernel, job, {}, segments.list, segment_ends_, counters_.total);
    for (std::size_t i = 0; i < segments.rays.size(); ++i) {
        const std::uint32_t ray = segments.rays[i];
        RayEnd& segment = segment_ends_[i];
        if (adds_action_to_time) segment.time = -segment.action;
        append(rays_.ends[ray], segment, job.outputs & output_integrals);
        rays_.ends[ray] = segment;
        std::copy_n(segments.list.starts[i].q, 3, origins_[ray].begin());
    }
    traced_[medium].insert(traced_[medium].end(), segments.rays.begin(), segments.rays.end());
}

}  // namespace

void GenerationCount::add(const GenerationCount& other) {
    rays += other.rays;
    active_lane_steps += other.active_lane_steps;
    issued_lane_steps += other.issued_lane_steps;
    nanoseconds += other.nanoseconds;
}

void trace_paths(const Plan& plan, const Job& job, const Tile& tile, BranchChoice choice, TracedRays& rays,
                 PathCounters& counters, const CancelToken& cancel) {
    Job cancellable = job;
    cancel.install(cancellable);
    rays.paths.clear();
    if (!plan.run.max_bounces && plan.media.empty()) {
        trace_tile(*plan.run.kernel, cancellable, tile, rays.list, rays.ends, counters.total);
        if (job.rays && rays.list.starts.empty())
            retrace_circling_rays(plan, cancellable, job.rays + tile.x0, rays.ends, counters.total);
        return;
    }
    Generations generations(plan, cancellable, tile, choice, rays, counters, cancel);
    generations.start();
    generations.follow();
}

}  // namespace kagero
