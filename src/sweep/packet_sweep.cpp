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

/// The properties of a set that all sets of one call of the kernel share, because they decide which events exist.
struct SetKind {
    bool changes_charts = false, changes_charts_at_turns = false, has_second_sheet = false;
    bool operator==(const SetKind&) const = default;
};

/// Sets of one kind whose rays bend, with the starts of these rays.
struct SetGroup {
    SetKind kind;
    std::vector<std::size_t> members;             ///< Indices of the sets.
    std::vector<ParameterSet> spaces;             ///< One per member.
    std::vector<RayStart> starts;                 ///< Those of the first member, then those of the second, etc.
    double chart_radius = 0, bending_radius = 0;  ///< The greatest of all members.
};

SetKind set_kind_of(const Scene& scene) {
    const bool spins = horizon_of_spinning_hole(scene.space).has_value();
    return {spins && scene.limits.chart_radius > 0, spins && is_nearly_extreme(scene.space),
            scene.limits.inner_escape_radius > 0};
}

/// All sets of a sweep.
struct DividedSets {
    std::vector<SetGroup> groups;       ///< The sets whose rays bend.
    std::vector<std::size_t> straight;  ///< The sets whose rays are straight.
};

/// Divides the sets into groups, and computes the starts of the rays that bend.
DividedSets divide_sets(const Plan& base, const ParameterSets& sets, const std::vector<RayInput>& rays,
                        std::optional<ObserverKind> observer) {
    SceneOfSets scenes(base, sets, observer);
    const Scene& scene = *scenes.plan.scene;
    DividedSets divided;
    std::vector<SetGroup>& groups = divided.groups;
    for (std::size_t set = 0; set < sets.count(); ++set) {
        scenes.select(set);
        if (scene.straight) {
            divided.straight.push_back(set);
            continue;
        }
        const SetKind kind = set_kind_of(scene);
        auto group = std::find_if(groups.begin(), groups.end(), [&](const SetGroup& g) { return g.kind == kind; });
        if (group == groups.end()) group = groups.insert(groups.end(), {kind, {}, {}, {}});
        group->members.push_back(set);
        const RayLimits& limits = scene.limits;
        group->spaces.push_back({sets.parameters(set), scene.space.hole(), limits.escape_radius,
                                 limits.inner_escape_radius, limits.capture_radius, limits.capture_stretch});
        if (kind.changes_charts) group->chart_radius = std::max(group->chart_radius, limits.chart_radius);
        group->bending_radius = std::max(group->bending_radius, scene.space.bending_radius());
        const std::vector<RayStart> starts = scenes.starts(rays);
        group->starts.insert(group->starts.end(), starts.begin(), starts.end());
    }
    return divided;
}

/// Returns the job of a group, without rays.
Job job_of_group(const Plan& base, const SetGroup& group, double first_step) {
    Job job = base.job();
    job.step = first_step;
    job.chart_radius = group.chart_radius;
    job.changes_chart_at_turns = group.kind.changes_charts_at_turns;
    if (!base.run.method.rescaled) job.bending_radius = group.bending_radius;
    job.capture_radius = std::numeric_limits<double>::infinity();
    job.inner_escape_radius = group.spaces.front().inner_escape_radius;
    job.parameter_limit /= base.scene->unit;
    job.refill = false;
    job.camera = nullptr;
    return job;
}

/// Traces the rays of a group in packets. The lanes of a packet contain the same ray in consecutive sets.
bool trace_group(const Plan& base, const ParameterSets& sets, const SetGroup& group, Job job, std::size_t rays,
                 const RunControl& control, std::vector<RayEnd>& ends) {
    const std::size_t members = group.members.size();
    std::vector<RayStart> starts(group.starts.size());
    for (std::size_t i = 0; i < rays; ++i)
        for (std::size_t m = 0; m < members; ++m) starts[i * members + m] = group.starts[m * rays + i];
    job.rays = starts.data();
    job.sets = group.spaces.data();
    job.set_count = static_cast<std::uint32_t>(members);
    Plan plan = base;
    plan.run.kernel = &base.module().sweep_kernel;
    WorkList work;
    for (std::uint32_t i = 0; i < starts.size(); i += rays_per_sweep_tile)
        work.tiles.push_back({i, 0, std::min(i + rays_per_sweep_tile, static_cast<std::uint32_t>(starts.size())), 1});
    const auto store = [&](const Tile& tile, const TracedRays& traced, const CancelToken&) {
        for (std::uint32_t i = tile.x0; i < tile.x1; ++i) {
            const std::size_t set = group.members[i % members];
            const Space& space = starts[i].ingoing ? sets.space(set) : base.scene->space;
            ends[set * rays + i / members] = reported_end(*base.scene, space, starts[i], traced.ends[i - tile.x0]);
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
    const char* refusal =
        sweep_kernel.refusal(base.scene->space.hamiltonian, method.integrator, method.rescaled, false);
    return refusal ? refusal : "";
}

bool trace_in_packets(const Plan& base, const ParameterSets& sets, const std::vector<RayInput>& rays,
                      std::optional<ObserverKind> observer, const RunControl& control, std::vector<RayEnd>& ends) {
    const double first_step = sets.first_step(base);
    const DividedSets divided = divide_sets(base, sets, rays, observer);
    for (const SetGroup& group : divided.groups)
        if (!trace_group(base, sets, group, job_of_group(base, group, first_step), rays.size(), control, ends))
            return false;
    return trace_set_by_set(base, sets, divided.straight, rays, observer, control, ends);
}

}  // namespace kagero
