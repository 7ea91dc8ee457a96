#include "scene/load/load_formula.h"

#include "formula/nodes.h"
#include "formula/parser.h"

#include "error.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// Bits of FormulaScope::variables: position x y z, momentum px py pz, and all variables, including pt.
constexpr unsigned position_bits = 0b0000111, momentum_bits = 0b0111000, all_bits = 0b1111111;

/// Parses the formula of a key. `allowed` contains the bits of the variables on which the formula may depend. Returns
/// the index of its root.
std::int32_t parse(FormulaScope& scope, const Value& value, const std::string& name, unsigned allowed = all_bits) {
    const std::int32_t node = parse_formula(scope, {to_text(value, name), name, value.location, allowed});
    const unsigned forbidden = scope.variables[static_cast<std::size_t>(node)] & ~allowed;
    for (std::size_t i = 0; i < formula_variables.size(); ++i) {
        if (!((forbidden >> i) & 1)) continue;
        const std::string legal = allowed == position_bits ? "x y z r theta phi rho" : "x y z pt r theta phi rho";
        throw InputError(value.location, name + " = " + to_toml(value.string) + " depends on " + formula_variables[i] +
                                             "; it may depend only on " + legal);
    }
    return node;
}

void load_constants(const Section& section, FormulaDescription& formula) {
    const Section table = subsection(section, "constants");
    if (!table.table) return;
    for (const Value& item : table.table->items) {
        const double value = to_number(item, full_name(table, item.key), {-1e300, 1e300});
        formula.constants.emplace_back(item.key, value);
        if (item.key == "pt") formula.parsed.pt = value;
        else define(formula.scope, item.key, number_node(formula.scope, value), item.key_location);
    }
}

void load_helpers(const Section& section, FormulaDescription& formula) {
    const Section table = subsection(section, "let");
    if (!table.table) return;
    for (const Value& item : table.table->items) {
        const std::string name = full_name(table, item.key);
        const std::int32_t node = parse_helper(formula.scope, {to_text(item, name), name, item.location});
        define(formula.scope, item.key, node, item.key_location);
        formula.helpers.emplace_back(item.key, item.string);
    }
}

/// Throws InputError if the parts do not sum to H. The sum and H are compared at pseudo-random points. Points at which
/// one of them is not finite are skipped.
void check_parts(const Section& section, const Value& parts, const FormulaDescription& formula) {
    constexpr int point_count = 64;
    constexpr double tolerance = 1e-10;  // rounding of a few hundred operations, and cancellation
    double seed = 0.5;
    const auto next_random = [&] { return seed = std::fmod(seed * 997.0 + 0.1234567, 1.0); };
    for (int i = 0; i < point_count; ++i) {
        FormulaPoint point{};
        for (double& x : point) x = (i % 4 + 0.5) * (2 * next_random() - 1);
        point[6] = formula.parsed.pt;
        const double h = evaluate(formula.scope, formula.parsed.energy, point);
        const double a = evaluate(formula.scope, formula.parsed.parts[0], point),
                     b = evaluate(formula.scope, formula.parsed.parts[1], point);
        if (!std::isfinite(h) || !std::isfinite(a + b)) continue;
        if (std::abs(h - a - b) <= tolerance * (1 + std::abs(h) + std::abs(a) + std::abs(b))) continue;
        std::string coordinates;
        for (std::size_t k = 0; k < 6; ++k) append_to_list(coordinates, to_toml(point[k]));
        throw InputError(parts.location, full_name(section, "parts") + " do not sum to " + full_name(section, "H") +
                                             ": at (x y z px py pz) = (" + coordinates + "), the parts give " +
                                             to_toml(a) + " + " + to_toml(b) + ", but H is " + to_toml(h));
    }
}

void load_parts(const Section& section, FormulaDescription& formula) {
    const Value* parts = find(section, "parts");
    if (!parts) return;
    const std::string name = full_name(section, "parts");
    if (parts->kind != Value::Kind::array || parts->items.size() != 2)
        fail(*parts, name, "an array of two formulas, H_A and H_B");
    for (std::size_t i = 0; i < 2; ++i) {
        formula.parsed.parts[i] = parse(formula.scope, parts->items[i], name + '[' + std::to_string(i) + ']');
        formula.parts.push_back(parts->items[i].string);
    }
    check_parts(section, *parts, formula);
}

/// Throws InputError if the formula is constant and its value is not greater than 0. Formulas that are not constant are
/// evaluated along the rays; a ray fails where the value is not positive.
void require_positive(const Value& value, const std::string& name, const FormulaScope& scope, std::int32_t node) {
    if (scope.variables[static_cast<std::size_t>(node)] != 0 || evaluate(scope, node, {}) > 0) return;
    fail(value, name, "a formula whose value is greater than 0");
}

/// Parses the formula of an optional key; the formula may depend on x y z pt. Sets `text` to the formula, and returns
/// the index of its root, or −1 if the key is missing.
std::int32_t load_optional(const Section& section, const std::string& key, FormulaDescription& formula,
                           std::string& text) {
    const Value* value = find(section, key);
    if (!value) return -1;
    text = to_text(*value, full_name(section, key));
    return parse(formula.scope, *value, full_name(section, key), all_bits & ~momentum_bits);
}

}  // namespace

FormulaDescription load_formula(const Section& section, const std::vector<std::string>& other_keys) {
    std::vector<std::string> keys{"H", "H0", "parts", "domain", "capture", "length_scale", "constants", "let"};
    keys.insert(keys.begin(), other_keys.begin(), other_keys.end());
    check_keys(section, keys);
    FormulaDescription formula;
    formula.table = section.name;
    formula.scope = formula_scope();
    const Value& energy = require(section, "H");
    formula.energy = to_text(energy, full_name(section, "H"));
    formula.location = energy.location;
    load_constants(section, formula);
    load_helpers(section, formula);
    formula.parsed.energy = parse(formula.scope, energy, full_name(section, "H"));
    const unsigned variables = formula.scope.variables[static_cast<std::size_t>(formula.parsed.energy)];
    if (!(variables & momentum_bits))
        fail(energy, full_name(section, "H"), "a formula that contains px, py or pz, because dq/dλ = ∂H/∂p");
    read(section, "H0", formula.level, {-1e300, 1e300});
    formula.parsed.level = formula.level;
    load_parts(section, formula);
    formula.parsed.domain = load_optional(section, "domain", formula, formula.domain);
    formula.far_domain_node = load_optional(section, "far_domain", formula, formula.far_domain);
    formula.parsed.capture = load_optional(section, "capture", formula, formula.capture);
    formula.parsed.length_scale = load_optional(section, "length_scale", formula, formula.length_scale);
    if (const Value* scale = find(section, "length_scale"))
        require_positive(*scale, full_name(section, "length_scale"), formula.scope, formula.parsed.length_scale);
    return formula;
}

FormulaDescription with_parameters(const FormulaDescription& formula, const std::vector<std::string>& names) {
    FormulaDescription result = formula;
    FormulaScope& scope = result.scope;
    scope = formula_scope();
    result.parsed = {nullptr, 0, -1, -1, -1, -1, -1, {-1, -1}, formula.parsed.level, formula.parsed.pt};
    result.parsed.parameter_count = static_cast<std::uint32_t>(names.size());
    for (const auto& [name, value] : formula.constants) {
        if (name == "pt") continue;
        const auto number = std::find(names.begin(), names.end(), name) - names.begin();
        const bool is_parameter = std::size_t(number) < names.size();
        define(scope, name,
               is_parameter ? parameter_node(scope, std::int32_t(number), value) : number_node(scope, value),
               formula.location);
    }
    for (const auto& [name, text] : formula.helpers)
        define(scope, name, parse_helper(scope, {text, formula.table + ".let." + name, formula.location}),
               formula.location);
    const auto root = [&](const std::string& text, const char* key) {
        return text.empty() ? -1 : parse_formula(scope, {text, formula.table + '.' + key, formula.location});
    };
    result.parsed.energy = root(formula.energy, "H");
    result.parsed.domain = root(formula.domain, "domain");
    result.far_domain_node = root(formula.far_domain, "far_domain");
    result.parsed.capture = root(formula.capture, "capture");
    result.parsed.length_scale = root(formula.length_scale, "length_scale");
    return result;
}

std::optional<VelocityDescription> load_velocity(const Section& section, const std::string& key,
                                                 SpaceDescription& space) {
    const Value* value = find(section, key);
    if (!value) return std::nullopt;
    const std::string name = full_name(section, key), expected = "an array of 3 numbers or formulas in x y z";
    if (value->kind != Value::Kind::array || value->items.size() != 3) fail(*value, name, expected);
    VelocityDescription velocity;
    velocity.location = value->location;
    velocity.scope = space.formula ? space.formula->scope : formula_scope();
    for (std::size_t i = 0; i < 3; ++i) {
        const Value& item = value->items[i];
        const std::string component = name + '[' + std::to_string(i) + ']';
        const bool is_number = item.kind == Value::Kind::number || item.kind == Value::Kind::integer;
        if (!is_number && item.kind != Value::Kind::string) fail(item, component, "a number or a formula in x y z");
        velocity.nodes[i] = is_number ? number_node(velocity.scope, to_number(item, component, {-1e300, 1e300}))
                                      : parse(velocity.scope, item, component, position_bits);
        velocity.components[i] = to_toml(item);
    }
    if (space.formula) space.formula->scope.used_names = velocity.scope.used_names;
    return velocity;
}

void load_rescaling(const Value& rescale, const std::string& name, SpaceDescription& space,
                    IntegratorDescription& integrator) {
    if (rescale.string == "auto" || rescale.string == "none") return;
    integrator.rescale_location = rescale.location;
    if (!space.formula) integrator.rescaling = {formula_scope(), -1};
    FormulaScope& scope = space.formula ? space.formula->scope : integrator.rescaling->scope;
    std::int32_t& node = space.formula ? space.formula->parsed.rescale : integrator.rescaling->node;
    node = parse(scope, rescale, name, position_bits);
    require_positive(rescale, name, scope, node);
}

}  // namespace kagero
