#include "sweep/sweep.h"

#include "error.h"
#include "rays/ray_ends.h"
#include "render/trace.h"
#include "scene/value.h"
#include "sweep/formula_sweep.h"
#include "sweep/packet_sweep.h"
#include "sweep/set_by_set.h"
#include "sweep/unread_keys.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace kagero {
namespace {

/// Throws InputError unless all keys differ and have the same number of values, at least one.
void check_keys_of_sweep(const std::vector<SweptKey>& keys, std::size_t rays) {
    if (keys.empty()) throw InputError("a sweep has no keys; state at least one key, such as \"space.rg\"");
    const SweptKey& first = keys.front();
    for (std::size_t i = 0; i < keys.size(); ++i) {
        const SweptKey& key = keys[i];
        if (key.count() == 0) throw InputError(key.key + " has no values; a sweep needs at least one value per key");
        if (key.count() != first.count())
            throw InputError(key.key + " has " + std::to_string(key.count()) +
                             (key.count() == 1 ? " value" : " values") + ", but " + first.key + " has " +
                             std::to_string(first.count()) +
                             "; all keys of a sweep must have the same number of values");
        for (std::size_t j = 0; j < i; ++j)
            if (keys[j].key == key.key)
                throw InputError(key.key + " occurs twice in a sweep; state the values of a key once");
    }
    constexpr std::size_t greatest = std::numeric_limits<std::uint32_t>::max();
    if (rays > greatest / first.count())
        throw InputError("a sweep of " + std::to_string(first.count()) + " sets of " + std::to_string(rays) +
                         " rays is too large: the greatest number of rays is " + std::to_string(greatest) +
                         "; divide the sweep into several");
}

/// Calls a function with the overrides of a set. An InputError names the set.
template <class Function>
auto call_with_set(const Function& function, const std::vector<SweptKey>& keys, std::size_t set) try {
    std::vector<std::string> overrides;
    for (const SweptKey& key : keys) overrides.push_back(key.key + "=" + key.text(set));
    return function(overrides);
} catch (const InputError& error) {
    throw InputError("set " + std::to_string(set) + " of the sweep: " + error.what());
}

Plan plan_of_set(const PlanWithOverrides& plan_with, const std::vector<SweptKey>& keys, std::size_t set) {
    return call_with_set(plan_with, keys, set);
}

/// Returns the plan of the first set whose rays bend; `first`, the plan of set 0, if there is none.
Plan plan_of_bent_set(const PlanWithOverrides& plan_with, const std::vector<SweptKey>& keys, const ParameterSets& sets,
                      const Plan& first) {
    for (std::size_t set = 0; first.scene->straight && set < sets.count(); ++set)
        if (!sets.space(set).is_straight()) return plan_of_set(plan_with, keys, set);
    return first;
}

/// Returns the reason why each set needs a plan of its own; empty if the keys are parameters of a compiled space, and
/// the rest of the scene does not depend on them.
std::string reason_for_separate_plans(const Plan& plan, const std::vector<SweptKey>& keys) {
    const Scene& scene = *plan.scene;
    const std::vector<ObjectDescription>& objects = scene.description.objects;
    const auto& formula = scene.description.space.formula;
    for (const SweptKey& key : keys) {
        const bool is_parameter = formula ? constant_of_key(*formula, key.key).has_value()
                                          : parameter_of_key(scene.space.info(), key.key).has_value();
        if (!is_parameter || !key.texts.empty())
            return key.key + " is not a " + (formula ? "constant" : "parameter") +
                   " with numbers that may differ between the rays of a packet";
    }
    if (formula && !formula->parts.empty()) return "space.parts are compared with space.H in each set";
    if (states_rescaling(scene)) return "integrator.rescale states an expression";
    if (plan.run.max_bounces || scene.regions || !scene.media.empty()) return "rays continue at surfaces";
    if (std::any_of(objects.begin(), objects.end(), [](const auto& object) { return object.shape == Shape::disk; }))
        return "the matter of a disk depends on the parameters";
    return "";
}

/// Returns true if the geometry depends on the set: surfaces near a spinning hole are in its coordinates.
bool geometry_depends_on_set(const Plan& plan, const ParameterSets& sets) {
    if (!plan.scene->geometry->kernel_view() || plan.description().space.formula) return false;
    for (std::size_t set = 0; set < sets.count(); ++set)
        if (sets.space(set).hole().spin != 0) return true;
    return false;
}

/// Returns the ends of rays that were not traced.
RayEnd untraced_end(const RayInput& ray) {
    RayStart start{};
    std::copy(ray.position.begin(), ray.position.end(), start.q);
    return end_at_start(start, Failure::untraced);
}

}  // namespace

void check_scenes_of_sets(const SceneWithOverrides& scene_with, const std::vector<SweptKey>& keys) {
    for (std::size_t set = 0; set < keys.front().count(); ++set) call_with_set(scene_with, keys, set);
}

Sweep::Sweep(PlanWithOverrides plan_with, std::vector<SweptKey> keys, std::size_t rays,
             std::optional<ObserverKind> observer)
    : plan_with_(std::move(plan_with)), keys_(std::move(keys)), observer_(observer) {
    check_keys_of_sweep(keys_, rays);
    plan_ = plan_of_set(plan_with_, keys_, 0);
    std::vector<std::string> names;
    for (const SweptKey& key : keys_) names.push_back(key.key);
    remarks_ = remarks_on_unread_keys(plan_, names);
    reason_ = reason_for_separate_plans(plan_, keys_);
    if (reason_.empty()) prepare_parameters();
}

/// Prepares a sweep whose keys are parameters of the space.
void Sweep::prepare_parameters() {
    parameters_.emplace(plan_, keys_);
    if (plan_.description().space.formula) return prepare_formula();
    if (geometry_depends_on_set(plan_, *parameters_)) {
        reason_ = "the coordinates of surfaces near a spinning hole depend on its parameters";
        parameters_.reset();
        return;
    }
    plan_ = plan_of_bent_set(plan_with_, keys_, *parameters_, plan_);
    reason_ = kagero::reason_against_packets(plan_);
    plan_of_packets_ = plan_;
    if (reason_.empty()) divided_ = divide_sets(plan_, *parameters_, observer_);
}

/// Prepares a sweep whose keys are constants of a formula. If its sets cannot share packets, each has its own plan.
void Sweep::prepare_formula() {
    reason_ = kagero::reason_against_packets(plan_);
    if (reason_.empty()) {
        ParameterPlan with_parameters = plan_with_parameters(plan_, keys_, *parameters_);
        plan_of_packets_ = std::move(with_parameters.plan);
        reason_ = with_parameters.refusal;
    }
    if (reason_.empty()) divided_ = divide_sets(plan_of_packets_, *parameters_, observer_);
    else parameters_.reset();
}

/// Traces the rays with a separate plan for each set. Returns false if the run is interrupted.
bool Sweep::trace_separately(const std::vector<RayInput>& rays, const RunControl& control, const EndsOfSets& ends,
                             std::vector<Plan>* plans) const {
    const SetRange& range = ends.range;
    for (std::size_t i = 0; i < range.count; ++i) {
        RunControl control_of_set = control;
        if (control.progress)
            control_of_set.progress = [&](double done, double seconds) {
                control.progress((double(i) + done) / double(range.count), seconds);
            };
        const Plan plan = plan_of_set(plan_with_, keys_, range.first + i);
        std::vector<RayEnd> ends_of_set;
        const RunReport report = kagero::trace(plan, start_rays(plan, rays, observer_), ends_of_set, control_of_set);
        std::copy(ends_of_set.begin(), ends_of_set.end(), ends.of(range.first + i));
        if (report.interrupted) return false;
        if (plans) plans->push_back(plan);
    }
    return true;
}

bool Sweep::trace(const SetRange& range, const std::vector<RayInput>& rays, const RunControl& control,
                  std::vector<RayEnd>& ends, std::vector<Plan>* plans) const {
    ends.clear();
    if (plans) plans->clear();
    for (std::size_t i = 0; i < range.count; ++i)
        for (const RayInput& ray : rays) ends.push_back(untraced_end(ray));
    const EndsOfSets place{range, rays.size(), ends};
    if (!parameters_) return trace_separately(rays, control, place, plans);
    if (reason_.empty())
        return trace_in_packets(plan_of_packets_, *parameters_, divided_, rays, observer_, control, place);
    std::vector<std::size_t> traced_sets(range.count);
    std::iota(traced_sets.begin(), traced_sets.end(), range.first);
    return trace_set_by_set(plan_, *parameters_, traced_sets, rays, observer_, control, place);
}

SweepResult sweep(const PlanWithOverrides& plan_with, const std::vector<SweptKey>& keys,
                  const std::vector<RayInput>& rays, std::optional<ObserverKind> observer, const RunControl& control) {
    const Sweep prepared(plan_with, keys, rays.size(), observer);
    SweepResult result;
    result.interrupted = !prepared.trace({0, prepared.sets()}, rays, control, result.ends);
    result.plan = prepared.plan();
    result.reason_against_packets = prepared.reason_against_packets();
    result.remarks = prepared.remarks();
    return result;
}

}  // namespace kagero
