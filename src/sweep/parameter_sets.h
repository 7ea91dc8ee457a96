/// The sets of a sweep in which only parameters of the space differ.
#pragma once

#include "plan/plan.h"

#include <string>
#include <vector>

namespace kagero {

/// A key of the scene, such as "space.rg", and its value in each set of the sweep: numbers, or texts as for the option
/// -D.
struct SweptKey {
    std::string key;
    std::vector<double> values;        ///< Empty if `texts` is not.
    std::vector<std::string> texts{};  ///< Values that are not all numbers.

    std::size_t count() const { return texts.empty() ? values.size() : texts.size(); }
    /// Returns the value in a set as for the option -D.
    std::string text(std::size_t set) const;
};

/// The values of all parameters of the space in every set, in the unit of the kernels. The parameters of a formula are
/// those of its constants that the keys set.
class ParameterSets {
public:
    /// `base` is the plan of a set. All keys must be parameters of its space, or constants of its formula, with numbers
    /// as values. Throws InputError if a value is not legal.
    ParameterSets(const Plan& base, const std::vector<SweptKey>& keys);

    std::size_t count() const { return count_; }
    /// Returns the parameters of a set in the declared order.
    const double* parameters(std::size_t set) const { return values_.data() + set * parameter_count_; }
    /// Returns the space of a set. The space must not be a formula.
    Space space(std::size_t set) const;
    /// Returns RunConfig::step of a set. The space must not be a formula.
    double step(const Plan& base, std::size_t set) const;
    /// Returns the first step of a method with step control in all sets: the stated step, or the least default step for
    /// all combinations of the least and greatest values of the keys. No set has a shorter default step, because the
    /// default is least at the least or greatest value of each parameter. A shorter first step takes more steps only at
    /// the start of a ray.
    double first_step(const Plan& base) const;

private:
    const Module* module_;
    std::uint32_t hamiltonian_;
    std::size_t parameter_count_, count_;
    std::vector<std::size_t> swept_;  ///< Indices of the parameters that the keys set; empty for a formula.
    std::vector<double> values_;      ///< The parameters of set 0, then those of set 1, etc.
};

/// Returns the name of the constant of a formula that a key "space.constants.NAME" sets; nothing if it sets none. `pt`
/// is no such constant.
std::optional<std::string> constant_of_key(const FormulaDescription& formula, const std::string& key);

/// Returns the index of the parameter of a space that a key "space.NAME" sets; nothing if it sets none.
std::optional<std::size_t> parameter_of_key(const HamiltonianInfo& space, const std::string& key);

}  // namespace kagero
