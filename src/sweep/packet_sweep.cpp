#include "sweep/packet_sweep.h"

#include "rays/ray_ends.h"
#include "render/run.h"
#include "spaces/charts.h"
#include "sweep/set_by_set.h"

#include <algorithm>
#include <limits>

namespace kagero {
namespace {

/// Number of rays in one tile of a sweep: several packets.
constexpr std::uint32_t rays_per_sweep_tile = 256;

SetKind set_kind_of(const Scene& scene) {
    const bool spins = horizon_of_spinning_hole(scene.space).has_value();
    return {spins && scene.limits.chart_radius > 0, spins && is_nearly_extreme(scene.space),
            scene.limits.inner_escape_radius > 0};
}

/// Sets of one group with the starts of their rays.
struct TracedSets {
    std::vector<std::size_t> members;  ///< Indices of the sets.
    std::vector<ParameterSet> spaces;  ///< One per member.
    std::vector<RayStart> starts;      ///< Start of ray i in member m: element i · members + m.
};

/// Computes the starts of the rays of those members of a group that the range contains.
TracedSets sets_in_range(const SetGroup& group, SceneOfSets& scenes, const ParameterSets& sets, const SetRange& range,
                         const std::vector<RayInput>& rays) {
    TracedSets traced;
    for (const std::size_t set : group.members)
        if (range.contains(set)) traced.members.push_back(set);
    const std::size_t members = traced.members.size();
    traced.starts.resize(members * rays.size());
    for (std::size_t m = 0; m < members; ++m) {
        const std::size_t set = traced.members[m];
        scenes.select(set);
        const Scene& scene = *scenes.plan.scene;
        const RayLimits& limits = scene.limits;
        traced.spaces.push_back({sets.parameters(set), scene.space.hole(), limits.escape_radius,
                                 limits.inner_escape_radius, limits.capture_radius, limits.capture_stretch});
        const std::vector<RayStart> starts = scenes.starts(rays);
        for (std::size_t i = 0; i < rays.size(); ++i) traced.starts[i * members + m] = starts[i];
    }
    return traced;
}

/// Returns the job of those members of a group that are traced.
Job job_of_group(const Plan& base, const SetGroup& group, const TracedSets& traced, double first_step) {
    Job job = base.job();
    job.step = first_step;
    job.chart_radius = group.chart_radius;
    job.changes_chart_at_turns = group.kind.changes_charts_at_turns;
    if (!base.run.method.rescaled) job.bending_radius = group.bending_radius;
    job.capture_radius = std::numeric_limits<double>::infinity();
    job.inner_escape_radius = traced.spaces.front().inner_escape_radius;
    job.parameter_limit /= base.scene->unit;
    job.refill = false;
    job.camera = nullptr;
    job.rays = traced.starts.data();
    job.sets = traced.spaces.data();
    job.set_count = static_cast<std::uint32_t>(traced.members.size());
    return job;
}

/// Traces the rays of a group in packets. The lanes of a packet contain the same ray in consecutive sets.
bool trace_group(const Plan& base, const ParameterSets& sets, const TracedSets& traced_sets, const Job& job,
                 const RunControl& control, const EndsOfSets& ends) {
    const std::vector<RayStart>& starts = traced_sets.starts;
    const std::size_t members = traced_sets.members.size();
    Plan plan = base;
    plan.run.kernel = &base.module().sweep_kernel;
    WorkList work;
    for (std::uint32_t i = 0; i < starts.size(); i += rays_per_sweep_tile)
        work.tiles.push_back({i, 0, std::min(i + rays_per_sweep_tile, static_cast<std::uint32_t>(starts.size())), 1});
    const auto store = [&](const Tile& tile, const TracedRays& traced, const CancelToken&) {
        for (std::uint32_t i = tile.x0; i < tile.x1; ++i) {
            const std::size_t set = traced_sets.members[i % members];
            const auto reported = [&](const Space& space) {
                return reported_end(*base.scene, space, starts[i], traced.ends[i - tile.x0]);
            };
            ends.of(set)[i / members] =
                starts[i].ingoing ? reported(sets.space(set)) : reported(base.scene->space);
        }
    };
    return !run_tiles(plan, job, work, {}, store, control).interrupted;
}

}  // namespace

std::string reason_against_packets(const Plan& base) {
    const KernelInfo &kernel = *base.run.kernel, &sweep_kernel = base.module().sweep_kernel;
    if (kernel.strategy != sweep_kernel.strategy || kernel.precision != sweep_kernel.precision)
        return "only packets of double contain rays of different sets";
    if (base.scene->straight) return "";
    if (!base.method().adaptive) return "the steps of the method do not adapt to the parameters";
    const MethodChoice& method = base.run.method;
    const Space& space = base.scene->space;
    const SpaceAndMethod combination{space.hamiltonian, space.parameters.data(), method.integrator, method.rescaled,
                                     false};
    const char* refusal = sweep_kernel.refusal(&combination);
    return refusal ? refusal : "";
}

DividedSets divide_sets(const Plan& base, const ParameterSets& sets, std::optional<ObserverKind> observer) {
    SceneOfSets scenes(base, sets, observer);
    const Scene& scene = *scenes.plan.scene;
    DividedSets divided;
    divided.first_step = sets.first_step(base);
    std::vector<SetGroup>& groups = divided.groups;
    for (std::size_t set = 0; set < sets.count(); ++set) {
        scenes.select(set);
        if (scene.straight) {
            divided.straight.push_back(set);
            continue;
        }
        const SetKind kind = set_kind_of(scene);
        auto group = std::find_if(groups.begin(), groups.end(), [&](const SetGroup& g) { return g.kind == kind; });
        if (group == groups.end()) group = groups.insert(groups.end(), {kind, {}});
        group->members.push_back(set);
        if (kind.changes_charts) group->chart_radius = std::max(group->chart_radius, scene.limits.chart_radius);
        group->bending_radius = std::max(group->bending_radius, scene.space.bending_radius());
    }
    return divided;
}

bool trace_in_packets(const Plan& base, const ParameterSets& sets, const DividedSets& divided,
                      const std::vector<RayInput>& rays, std::optional<ObserverKind> observer,
                      const RunControl& control, const EndsOfSets& ends) {
    SceneOfSets scenes(base, sets, observer);
    for (const SetGroup& group : divided.groups) {
        const TracedSets traced = sets_in_range(group, scenes, sets, ends.range, rays);
        if (traced.starts.empty()) continue;
        const Job job = job_of_group(base, group, traced, divided.first_step);
        if (!trace_group(base, sets, traced, job, control, ends)) return false;
    }
    std::vector<std::size_t> straight;
    for (const std::size_t set : divided.straight)
        if (ends.range.contains(set)) straight.push_back(set);
    return trace_set_by_set(base, sets, straight, rays, observer, control, ends);
}

}  // namespace kagero
