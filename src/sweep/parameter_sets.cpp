#include "sweep/parameter_sets.h"

#include "scene/load/load_integrator.h"
#include "scene/load/load_space.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kagero {
namespace {

/// Greatest number of keys for whose corners default steps are computed; further keys keep the value of set 0.
constexpr std::size_t max_corner_keys = 8;

/// Returns a value of a key as a value of a scene file, whose position names the set.
Value value_in_set(const SweptKey& key, std::size_t set) {
    Value value;
    value.kind = Value::Kind::number;
    value.number = key.values[set];
    value.location = {"value " + std::to_string(set) + " of " + key.key, 0, 0};
    return value;
}

/// Returns the stated step, or the default step for the parameters of `space`, in the unit of the kernels.
double step_in(const Plan& base, const SpaceDescription& space) {
    const IntegratorDescription& stated = base.description().integrator;
    if (stated.step_location) return base.run.step;
    const StepKind kind = step_kind(*base.scene, base.run.method.integrator, base.run.method.rescaled);
    return default_steps(base.scene->space.info(), space, stated.escape_radius)[static_cast<std::size_t>(kind)];
}

}  // namespace

std::string SweptKey::text(std::size_t set) const { return texts.empty() ? to_toml(values[set]) : texts[set]; }

std::optional<std::size_t> parameter_of_key(const HamiltonianInfo& space, const std::string& key) {
    for (std::size_t i = 0; i < space.parameter_count; ++i)
        if (key == std::string("space.") + space.parameters[i].name) return i;
    return std::nullopt;
}

std::optional<std::string> constant_of_key(const FormulaDescription& formula, const std::string& key) {
    for (const auto& [name, value] : formula.constants)
        if (name != "pt" && key == formula.table + ".constants." + name) return name;
    return std::nullopt;
}

ParameterSets::ParameterSets(const Plan& base, const std::vector<SweptKey>& keys)
    : module_(&base.module()), hamiltonian_(base.scene->space.hamiltonian),
      parameter_count_(base.scene->space.parameters.size()), count_(keys.front().count()) {
    if (base.description().space.formula) {
        parameter_count_ = keys.size();
        for (std::size_t set = 0; set < count_; ++set)
            for (const SweptKey& key : keys)
                values_.push_back(to_number(value_in_set(key, set), key.key, {-1e300, 1e300}));
        return;
    }
    const HamiltonianInfo& info = base.scene->space.info();
    values_.reserve(count_ * parameter_count_);
    for (std::size_t set = 0; set < count_; ++set)
        values_.insert(values_.end(), base.scene->space.parameters.begin(), base.scene->space.parameters.end());
    for (const SweptKey& key : keys) {
        const std::size_t i = swept_.emplace_back(parameter_of_key(info, key.key).value());
        const double factor = std::pow(base.scene->unit, -power_of_length(info.parameters[i].unit));
        for (std::size_t set = 0; set < count_; ++set)
            values_[set * parameter_count_ + i] =
                factor * to_parameter(value_in_set(key, set), key.key, info.parameters[i]);
    }
}

Space ParameterSets::space(std::size_t set) const {
    return {module_, hamiltonian_, {parameters(set), parameters(set) + parameter_count_}};
}

double ParameterSets::step(const Plan& base, std::size_t set) const {
    SpaceDescription space = base.description().space;
    for (const std::size_t i : swept_) space.parameters[i].second = parameters(set)[i];
    return step_in(base, space);
}

double ParameterSets::first_step(const Plan& base) const {
    if (base.description().space.formula) return base.run.step;
    const std::size_t keys = std::min(swept_.size(), max_corner_keys);
    std::vector<std::array<double, 2>> ranges;
    for (std::size_t k = 0; k < keys; ++k) {
        std::array<double, 2>& range = ranges.emplace_back();
        range.fill(parameters(0)[swept_[k]]);
        for (std::size_t set = 1; set < count_; ++set) {
            range[0] = std::min(range[0], parameters(set)[swept_[k]]);
            range[1] = std::max(range[1], parameters(set)[swept_[k]]);
        }
    }
    SpaceDescription corner = base.description().space;
    double least = base.run.step;
    for (std::size_t bits = 0; bits < std::size_t(1) << keys; ++bits) {
        for (std::size_t k = 0; k < keys; ++k) corner.parameters[swept_[k]].second = ranges[k][bits >> k & 1];
        if (const double step = step_in(base, corner); step > 0) least = std::min(least, step);
    }
    return least;
}

}  // namespace kagero
