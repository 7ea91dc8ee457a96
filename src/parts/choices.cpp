#include "parts/choices.h"

#include "error.h"
#include "plan/names.h"

#include <algorithm>
#include <charconv>
#include <type_traits>

namespace kagero {
namespace {

/// Visits all numbers of a run that a trial can set, by name. Threads, schedule and the conditions on the kernel are
/// not choices of a trial.
template <class Run, class Visit>
void for_each_number(Run& run, const Visit& visit) {
    visit("rescaled", run.method.rescaled);
    visit("step", run.step);
    visit("tolerance", run.tolerance);
    visit("solver_tolerance", run.solver_tolerance);
    visit("max_steps", run.max_steps);
    visit("max_step_radius_ratio", run.max_step_radius_ratio);
    visit("max_step_length", run.max_step_length);
    visit("first_step_length", run.first_step_length);
    visit("position_scale", run.position_scale);
    visit("momentum_scale", run.momentum_scale);
    visit("value_weight", run.value_weight);
    visit("max_momentum", run.max_momentum);
    visit("min_step_length", run.min_step_length);
    visit("use_symmetry", run.use_symmetry);
    visit("hit", run.hit);
    visit("chord_tolerance", run.chord_tolerance);
    visit("surfaces", run.surfaces);
    visit("refill", run.refill);
    visit("scanlines", run.scanlines);
    visit("outputs", run.outputs);
}

template <class Trial, class Visit>
void for_each_trial_number(Trial& trial, const Visit& visit) {
    visit("trial_rays", trial.rays);
    visit("trial_bound_is_stated", trial.is_stated);
    visit("trial_bound", trial.bound);
    visit("trial_estimate", trial.estimate);
    visit("trial_bound_is_met", trial.bound_met);
    visit("trial_ill_conditioned_share", trial.ill_conditioned_share);
}

/// Returns the shortest text that is read as the same number.
template <class Number>
std::string text_of_number(Number number) {
    if constexpr (std::is_enum_v<Number>) {
        return text_of_number(static_cast<std::underlying_type_t<Number>>(number));
    } else if constexpr (std::is_same_v<Number, bool>) {
        return number ? "1" : "0";
    } else {
        char text[64];
        return {text, std::to_chars(text, text + sizeof text, number).ptr};
    }
}

/// The kernel as a text: its index in the module, and its properties for a check.
std::string kernel_text(const Module& module, std::uint32_t index) {
    const KernelInfo& kernel = module.kernels[index];
    return std::to_string(index) + ": " + name_of(kernel.strategy) + " " + name_of(kernel.precision) + " " +
           name_of(kernel.form) + " " + std::to_string(kernel.lanes) + " lanes, " + std::to_string(kernel.registers) +
           " registers";
}

/// The choices of a file, by name.
class ChoiceReader {
public:
    ChoiceReader(const Properties& choices, const std::string& path) : choices_(choices), path_(path) {}

    const std::string* find(const std::string& name) const {
        const auto found =
            std::find_if(choices_.begin(), choices_.end(), [&](const auto& choice) { return choice.first == name; });
        return found == choices_.end() ? nullptr : &found->second;
    }
    const std::string& text(const std::string& name) const {
        if (const std::string* value = find(name)) return *value;
        refuse(name, "missing");
    }
    template <class Number>
    void operator()(const char* name, Number& number) const {
        if constexpr (std::is_enum_v<Number>) {
            std::underlying_type_t<Number> value{};
            (*this)(name, value);
            number = static_cast<Number>(value);
        } else if constexpr (std::is_same_v<Number, bool>) {
            number = text(name) == "1";
        } else {
            const std::string& value = text(name);
            const char* const end = value.data() + value.size();
            const auto parsed = std::from_chars(value.data(), end, number);
            if (parsed.ec != std::errc{} || parsed.ptr != end) refuse(name, "'" + value + "'");
        }
    }
    [[noreturn]] void refuse(const std::string& name, const std::string& value) const {
        throw InputError(path_ + " was written by another build of kagero: its choice of " + name + " is " + value +
                         ", which this program does not have; use the kagero that wrote the file");
    }

private:
    const Properties& choices_;
    const std::string& path_;
};

MethodTrial trial_of(const ChoiceReader& read) {
    MethodTrial trial;
    for_each_trial_number(trial, read);
    trial.failure_reason = read.text("trial_failure_reason");
    std::uint64_t remarks = 0;
    read("trial_remarks", remarks);
    for (std::uint64_t i = 0; i < remarks; ++i) trial.remarks.push_back(read.text("trial_remark_" + std::to_string(i)));
    return trial;
}

}  // namespace

Properties choices_of(const Plan& plan) {
    Properties choices;
    const auto add_number = [&](const char* name, const auto& number) {
        choices.emplace_back(name, text_of_number(number));
    };
    const Module& module = plan.module();
    choices.emplace_back("method", plan.method().name);
    choices.emplace_back("kernel", kernel_text(module, static_cast<std::uint32_t>(plan.run.kernel - module.kernels)));
    for_each_number(plan.run, add_number);
    if (!plan.method_trial) return choices;
    const MethodTrial& trial = *plan.method_trial;
    for_each_trial_number(trial, add_number);
    choices.emplace_back("trial_failure_reason", trial.failure_reason);
    add_number("trial_remarks", std::uint64_t{trial.remarks.size()});
    for (std::size_t i = 0; i < trial.remarks.size(); ++i)
        choices.emplace_back("trial_remark_" + std::to_string(i), trial.remarks[i]);
    return choices;
}

Plan with_choices(Plan plan, const Properties& choices, const std::string& path) {
    const ChoiceReader read(choices, path);
    const Module& module = plan.module();
    const std::vector<std::string> methods = names_of(module.integrators, module.integrator_count);
    const auto method = std::find(methods.begin(), methods.end(), read.text("method"));
    if (method == methods.end()) read.refuse("method", read.text("method"));
    plan.run.method.integrator = static_cast<std::uint32_t>(method - methods.begin());
    std::uint32_t kernel = 0;
    while (kernel < module.kernel_count && kernel_text(module, kernel) != read.text("kernel")) ++kernel;
    if (kernel == module.kernel_count) read.refuse("kernel", read.text("kernel"));
    plan.run.kernel = &module.kernels[kernel];
    for_each_number(plan.run, read);
    if (read.find("trial_rays")) plan.method_trial = trial_of(read);
    return plan;
}

}  // namespace kagero
