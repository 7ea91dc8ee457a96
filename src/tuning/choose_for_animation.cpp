#include "tuning/choose_for_animation.h"

#include "animation/animation.h"
#include "rays/camera.h"
#include "rays/sampler.h"
#include "scene/load/load.h"
#include "tuning/choose_by_trial.h"
#include "tuning/choose_method.h"
#include "tuning/precision.h"
#include "tuning/step_bound.h"

#include <algorithm>

namespace kagero {
namespace {

/// One frame of the trial.
struct TrialFrame {
    double frame;
    Plan plan;   ///< The plan before the choices.
    Plan tuned;  ///< The plan with the choices for this frame alone.
};

std::vector<double> frames_of_trial(std::uint32_t frames) {
    std::vector<double> chosen{0, double(frames / 2), double(frames - 1)};
    chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
    return chosen;
}

/// Returns "0, 120 and 239".
std::string frames_text(const std::vector<double>& frames) {
    std::string text;
    for (std::size_t i = 0; i < frames.size(); ++i)
        text += (i == 0 ? "" : i + 1 == frames.size() ? " and " : ", ") + plain_number(frames[i]);
    return text;
}

/// Returns the operations per ray of the choice for one frame; infinity if no method is known to meet the bound.
double rank_of(const TrialFrame& frame) {
    const MethodTrial& trial = *frame.tuned.method_trial;
    return trial.bound_met && trial.operations > 0 ? trial.operations : std::numeric_limits<double>::infinity();
}

/// Returns the step of a plan in the unit of the scene file, or its tolerance.
double accuracy_of(const Plan& plan) {
    return plan.method().adaptive ? plan.run.tolerance : stated_step(*plan.scene, plan.run);
}

/// Returns the plan of a frame whose method is that of another frame, with the step that the frame needs.
Plan tuned_with_method(const TrialFrame& frame, const Plan& other, const Options& options, const RunControl& control) {
    if (frame.tuned.run.method.integrator == other.run.method.integrator) return frame.tuned;
    SceneDescription description = load_frame(frame.plan.description(), catalogue(options.isa), frame.frame);
    description.integrator.method = other.method().name;
    description.integrator.method_location = FileLocation{description.path, 0, 0};
    Plan plan = make_plan(std::move(description), options, Purpose::picture, frame.plan.scene.get());
    return choose_method(choose_step_bound(std::move(plan), options, Purpose::picture, control), control);
}

/// Adds the result of the trial of one frame to those of the frames before.
void add_trial(const Plan& plan, double frame, MethodTrial& sum) {
    const MethodTrial& trial = *plan.method_trial;
    const bool is_first = sum.rays == 0;
    sum.bound_met = (is_first || sum.bound_met) && trial.bound_met;
    sum.rays += trial.rays;
    sum.is_stated = trial.is_stated;
    sum.bound = trial.bound;
    sum.estimate = std::max(sum.estimate, trial.estimate);
    sum.operations = std::max(sum.operations, trial.operations);
    sum.ill_conditioned_share = std::max(sum.ill_conditioned_share, trial.ill_conditioned_share);
    if (sum.failure_reason.empty() && !trial.failure_reason.empty())
        sum.failure_reason = "in frame " + plain_number(frame) + ", " + trial.failure_reason;
    for (const std::string& remark : trial.remarks)
        if (std::find(sum.remarks.begin(), sum.remarks.end(), remark) == sum.remarks.end())
            sum.remarks.push_back(remark);
}

/// Returns the choice with the method of one frame, and the step that the most demanding frame needs.
AnimationChoice choice_with_method_of(const TrialFrame& pivot, const std::vector<TrialFrame*>& bent,
                                      const Options& options, const RunControl& control) {
    AnimationChoice choice;
    choice.method = pivot.tuned.run.method;
    choice.step = accuracy_of(pivot.tuned);
    choice.value_weight = pivot.tuned.run.value_weight;
    for (const TrialFrame* frame : bent) {
        const Plan tuned = tuned_with_method(*frame, pivot.tuned, options, control);
        if (tuned.run.method.integrator == choice.method->integrator) {
            choice.step = std::min(choice.step, accuracy_of(tuned));
            choice.method->rescaled = choice.method->rescaled && tuned.run.method.rescaled;
            choice.value_weight = std::min(choice.value_weight, tuned.run.value_weight);
        }
        add_trial(tuned, frame->frame, choice.trial);
    }
    return choice;
}

/// Chooses the method for the frames whose rays bend. Prefers the method of the frame whose choice needs the most
/// operations; another one is taken only if the first does not meet the bound in all frames.
AnimationChoice choose_common_method(std::vector<TrialFrame*> bent, const Options& options, const RunControl& control) {
    std::vector<TrialFrame*> ranked = bent;
    std::stable_sort(ranked.begin(), ranked.end(),
                     [](const TrialFrame* a, const TrialFrame* b) { return rank_of(*a) > rank_of(*b); });
    std::optional<AnimationChoice> first;
    for (const TrialFrame* pivot : ranked) {
        AnimationChoice choice = choice_with_method_of(*pivot, bent, options, control);
        if (choice.trial.bound_met) return choice;
        if (!first) first = std::move(choice);
    }
    return *first;
}

/// Returns the plan with the method of the choice. Returns nullopt if the space does not support the method, or if
/// there is no kernel for it. A plan that needs no choice of its method is unchanged.
std::optional<Plan> with_common_method(Plan plan, const AnimationChoice& choice) {
    if (!needs_method_search(plan) || !choice.method) return plan;
    Variant variant{*choice.method};
    if (refusal_of(*plan.scene, variant.method.integrator, variant.method.rescaled)) return {};
    variant.step = info_of(plan, variant).adaptive ? choice.step : kernel_step(plan, variant, choice.step);
    const std::optional<RunConfig> run = run_config_with(plan, variant);
    if (!run) return {};
    plan.run = *run;
    plan.run.value_weight = choice.value_weight;
    plan.method_trial = choice.trial;
    plan.decisions.motion = motion_decisions(*plan.scene, plan.run, true);
    return plan;
}

/// Sets AnimationChoice::use_float from trials with the common method.
void choose_common_precision(const std::vector<TrialFrame>& frames, const RunControl& control,
                             AnimationChoice& choice) {
    choice.use_float = true;
    for (const TrialFrame& frame : frames) {
        const std::optional<Plan> plan = with_common_method(frame.plan, choice);
        if (!plan) continue;
        const Plan tuned = choose_precision(*plan, control.stop);
        if (tuned.run.kernel->precision == Precision::float32) continue;
        choice.use_float = false;
        choice.reason_for_double = "in frame " + plain_number(frame.frame) + ", " +
                                   (tuned.precision_trial ? tuned.precision_trial->reason_for_double : "");
        return;
    }
}

/// Returns the plan with the precision of the choice. A frame whose camera needs double, or for which there is no float
/// kernel, is traced in double.
Plan with_common_precision(Plan plan, const AnimationChoice& choice) {
    if (plan.run.kernel_request.precision) return plan;
    PrecisionTrial trial;
    trial.reason_for_double = choice.reason_for_double;
    if (choice.use_float) {
        KernelRequest request = plan.run.kernel_request;
        request.precision = Precision::float32;
        const KernelInfo* kernel = find_kernel(*plan.scene, plan.run.method, request);
        if (!kernel) trial.reason_for_double = "no float kernel supports the method and integrator.lanes";
        else if (camera_needs_double(*plan.scene, plan.view))
            trial.reason_for_double = "the momentum of a camera this close to a horizon is too large for float";
        else plan.run.kernel = kernel;
    }
    const bool is_float = trial.reason_for_double.empty();
    plan.decisions.tuning.push_back(
        {is_float ? "float, in which trials of frames " + frames_text(choice.frames) + " are accurate enough" : "float",
         is_float, trial.reason_for_double});
    plan.precision_trial = trial;
    return plan;
}

/// Returns the decision that `explain` prints about the method.
Decision decision_of_animation(const Plan& plan, const AnimationChoice& choice) {
    const std::string feature =
        "choice of method and step for all frames of the animation, by trials of frames " + frames_text(choice.frames);
    if (plan.scene->straight) return {feature, false, "all rays are straight"};
    if (!needs_method_search(plan)) return {feature, false, "the scene states the step or the tolerance"};
    std::string chosen = feature + ": " + plan.method().name + " with " +
                         (plan.method().adaptive ? "tolerance " : "step ") + plain_number(accuracy_of(plan));
    if (!choice.trial.bound_met) return {chosen, true, {}};
    chosen += ", the most accurate choice that one of them needs; the error is " + plain_number(choice.trial.estimate) +
              " pixels for 99 % of " + std::to_string(choice.trial.rays) + " rays";
    return {chosen, true, {}};
}

/// Returns a seed for the random paths of one sample. Equal samples of different seeds have different paths.
std::uint32_t seed_of_sample(std::uint32_t seed, std::uint32_t sample) {
    std::uint64_t bits = (std::uint64_t{seed} << 32 | sample) * 0x9e3779b97f4a7c15u;  // golden ratio
    bits = (bits ^ bits >> 31) * 0xbf58476d1ce4e5b9u;                                 // finalizer of splitmix64
    return static_cast<std::uint32_t>(bits >> 32);
}

}  // namespace

bool has_changing_frames(const SceneDescription& scene) { return scene.animation && !scene.animation->keys.empty(); }

Plan plan_of_frame(const SceneDescription& scene, double frame, const Options& options, const Scene* earlier,
                   std::optional<std::uint32_t> sample, const RunControl& control) {
    SceneDescription description = load_frame(scene, catalogue(options.isa), frame);
    const std::uint32_t spp = description.film.spp, seed = description.film.seed;
    if (sample) {
        description.film.spp = 1;
        description.film.seed = seed_of_sample(seed, *sample);
    }
    try {
        Plan plan = make_plan(std::move(description), options, Purpose::picture, earlier);
        plan = choose_step_bound(std::move(plan), options, Purpose::picture, control);
        if (sample) {
            const auto [x, y] = sample_position(0, 0, *sample, spp, seed);
            plan = with_displaced_rays(std::move(plan), x - 0.5, y - 0.5);
            plan.run.is_one_sample = spp > 1;
        }
        return plan;
    } catch (const InputError& error) {
        throw in_frame(error, frame);
    }
}

AnimationChoice choose_for_animation(const SceneDescription& scene, const Options& options, const RunControl& control) {
    std::vector<TrialFrame> frames;
    const Scene* earlier = nullptr;
    const std::vector<double> numbers = frames_of_trial(scene.animation->frames);
    frames.reserve(numbers.size());
    for (const double number : numbers) {
        Plan plan = plan_of_frame(scene, number, options, earlier, {}, control);
        frames.push_back({number, plan, choose_by_trial(plan, control)});
        earlier = frames.back().plan.scene.get();
    }
    std::vector<TrialFrame*> bent;
    for (TrialFrame& frame : frames)
        if (frame.tuned.method_trial) bent.push_back(&frame);
    AnimationChoice choice;
    if (!bent.empty()) choice = choose_common_method(bent, options, control);
    choice.frames = numbers;
    choose_common_precision(frames, control, choice);
    choice.scene = frames.front().plan.scene;
    return choice;
}

Plan with_choice(Plan plan, const AnimationChoice& choice, const RunControl& control) {
    std::optional<Plan> common = with_common_method(plan, choice);
    if (!common) return choose_by_trial(std::move(plan), control);
    common->decisions.tuning.push_back(decision_of_animation(*common, choice));
    return with_common_precision(std::move(*common), choice);
}

}  // namespace kagero
