#include "animation/animation.h"

#include "formula/nodes.h"
#include "formula/parser.h"
#include "scene/overrides.h"
#include "scene/reader.h"
#include "scene/toml.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

bool is_stated_number(const Value& value) {
    return value.kind == Value::Kind::number || value.kind == Value::Kind::integer;
}

/// Reads a number or the text of an expression. Numbers are checked later, like the values of expressions.
AnimatedNumber load_number(const Value& value, const std::string& name) {
    if (!is_stated_number(value) && value.kind != Value::Kind::string)
        fail(value, name, "a number, or an expression of frame, u, w and s as a string, such as \"0.1*u\"");
    return {to_toml(value), value.location};
}

/// Throws InputError for keys that no frame may change.
void refuse_fixed(const Value& entry, const std::vector<std::string>& path) {
    const auto refuse = [&](const std::string& reason) {
        throw InputError(entry.key_location, "animation.set cannot contain " + to_toml(entry.key) + ": " + reason);
    };
    if (path[0] == "film" && path.size() > 1 && path[1] == "size")
        refuse("all frames have the same size; state film.size, or use --size");
    if (path[0] == "animation") refuse("an animation cannot change itself");
    if (entry.kind == Value::Kind::table)
        refuse("write the whole path as one quoted key, such as \"camera.fov\" or \"object.NAME.radius\"");
}

AnimatedKey load_key(const Value& entry) {
    AnimatedKey key;
    key.key = entry.key;
    key.location = entry.key_location;
    key.path = keys_of_path(entry.key, entry.key_location);
    refuse_fixed(entry, key.path);
    const std::string name = "animation.set." + to_toml(entry.key);
    key.is_array = entry.kind == Value::Kind::array;
    if (!key.is_array) {
        key.numbers.push_back(load_number(entry, name));
        return key;
    }
    for (std::size_t i = 0; i < entry.items.size(); ++i)
        key.numbers.push_back(load_number(entry.items[i], name + '[' + std::to_string(i) + ']'));
    return key;
}

/// The quantities that expressions may contain.
struct FrameVariables {
    double frame, u, w, s;
};

/// Returns the value of an expression. Its quantities are constants, so that parsing evaluates it.
double value_of_expression(const FormulaText& formula, const FrameVariables& at) {
    FormulaScope scope = formula_scope();
    const std::pair<const char*, double> names[] = {{"frame", at.frame}, {"u", at.u}, {"w", at.w}, {"s", at.s}};
    for (const auto& [name, value] : names) define(scope, name, number_node(scope, value), formula.location);
    const std::int32_t node = parse_formula(scope, formula);
    if (scope.variables[static_cast<std::size_t>(node)] != 0)
        throw InputError(formula.location, formula.name + " = " + to_toml(formula.text) +
                                               " depends on the position or momentum of a ray; it may depend only on "
                                               "frame, u, w and s");
    return evaluate(scope, node, {});
}

/// Returns the value of a number or expression as a number at its position in the file. A whole number is an integer,
/// so that keys such as film.seed can be animated.
Value value_at(const AnimatedNumber& number, const std::string& name, const FrameVariables& at) {
    Value value = parse_toml_value(number.text, number.location);
    if (is_stated_number(value)) return value;
    const double x = value_of_expression({value.string, name, number.location, 0}, at);
    if (!std::isfinite(x))
        throw InputError(number.location, name + " = " + number.text + " is not a finite number: its value is " +
                                              to_toml(x) + "; change the expression");
    constexpr double max_whole = 9e15;  // double represents all whole numbers up to 2^53
    const bool is_whole = x == std::floor(x) && std::abs(x) < max_whole;
    value.kind = is_whole ? Value::Kind::integer : Value::Kind::number;
    value.number = is_whole && x == 0 ? 0 : x;
    value.integer = is_whole ? static_cast<std::int64_t>(x) : 0;
    value.string.clear();
    return value;
}

Value value_at(const AnimatedKey& key, const FrameVariables& at) {
    const std::string name = "animation.set." + to_toml(key.key);
    if (!key.is_array) return value_at(key.numbers.front(), name, at);
    Value array;
    array.kind = Value::Kind::array;
    array.location = key.numbers.empty() ? key.location : key.numbers.front().location;
    for (std::size_t i = 0; i < key.numbers.size(); ++i)
        array.items.push_back(value_at(key.numbers[i], name + '[' + std::to_string(i) + ']', at));
    return array;
}

}  // namespace

std::optional<AnimationDescription> load_animation(const Value& root) {
    const Section table = section(root, "animation");
    if (!table.table) return {};
    check_keys(table, {"frames", "fps", "set"});
    AnimationDescription animation;
    animation.frames = to_count(require(table, "frames"), "animation.frames", 1, max_frames);
    read(table, "fps", animation.fps, {0, 1e6, true});
    const Section set = subsection(table, "set");
    if (!set.table) return animation;
    for (const Value& entry : set.table->items) {
        AnimatedKey key = load_key(entry);
        for (const AnimatedKey& other : animation.keys)
            if (other.path == key.path)
                throw InputError(entry.key_location, "animation.set contains " + to_toml(other.key) + " and " +
                                                         to_toml(key.key) + ", which are the same key; remove one");
        animation.keys.push_back(std::move(key));
    }
    return animation;
}

void fix_key(AnimationDescription& animation, const std::vector<std::string>& path) {
    std::erase_if(animation.keys, [&](const AnimatedKey& key) { return key.path == path; });
}

void set_frame(Value& root, AnimationDescription& animation, double frame) {
    FrameVariables at{frame, frame / animation.frames, 0, frame / animation.fps};
    if (animation.frames > 1) at.w = frame / (animation.frames - 1);
    animation.frame = frame;
    animation.values.clear();
    for (const AnimatedKey& key : animation.keys) {
        Value value = value_at(key, at);
        value.key_location = key.location;
        animation.values.emplace_back(key.key, to_toml(value));
        set_value(root, key.path, std::move(value), key.location);
    }
}

InputError in_frame(const InputError& error, double frame) {
    const std::string prefix = InputError(error.location, "").what(), text = error.what();
    return {error.location, (text.starts_with(prefix) ? text.substr(prefix.size()) : text) + " (in frame " +
                                to_toml(frame) + " of the animation)"};
}

}  // namespace kagero
