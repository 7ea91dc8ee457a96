#include "scene/overrides.h"

#include "scene/toml.h"

#include <algorithm>
#include <initializer_list>

namespace kagero {

namespace {

std::string trimmed(const std::string& text) {
    const auto first = text.find_first_not_of(" \t");
    if (first == std::string::npos) return "";
    return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

/// Splits the path before '=', such as `object."left wall".color`, at its dots, and returns its keys. Keys may be
/// quoted. Sets `end` to the position of '='.
std::vector<std::string> split_path(const std::string& text, std::size_t& end, const FileLocation& location) {
    std::vector<std::string> path{""};
    char quote = 0;
    for (end = 0; end < text.size(); ++end) {
        const char letter = text[end];
        if (quote) {
            if (letter == quote)
                quote = 0;
            else
                path.back() += letter;
        } else if (letter == '"' || letter == '\'') {
            quote = letter;
        } else if (letter == '=') {
            break;
        } else if (letter == '.') {
            path.emplace_back();
        } else {
            path.back() += letter;
        }
    }
    for (std::string& key : path) key = trimmed(key);
    const bool has_empty_key = std::find(path.begin(), path.end(), "") != path.end();
    if (end == text.size() || has_empty_key)
        throw InputError(location, "an override has the form key.path=value, for example space.rg=0.1");
    return path;
}

/// Returns the table with the given name in the array `array`, "object" or "medium". An object without a name is named
/// object-N if it is object number N.
Value& table_named(Value& root, const std::string& array, const std::string& name, const FileLocation& location) {
    std::vector<std::string> names;
    for (Value& item : root.items) {
        if (item.key != array || item.kind != Value::Kind::array) continue;
        for (Value& table : item.items) {
            const Value* given = find(table, "name");
            const bool has_name = given && given->kind == Value::Kind::string;
            names.push_back(has_name ? given->string : array + '-' + std::to_string(names.size() + 1));
            if (names.back() == name) return table;
        }
    }
    const std::string plural = array == "medium" ? "media" : "objects";
    std::string message = "there is no " + array + ' ' + to_toml(name);
    const std::string near = near_match(name, names);
    if (!near.empty()) message += "; did you mean " + to_toml(near) + '?';
    message += names.empty()  ? "; the scene has no " + plural
               : near.empty() ? "; the " + plural + " are:"
                              : " The " + plural + " are:";
    for (const std::string& known : names) message += ' ' + known;
    throw InputError(location, message);
}

/// Returns the table `key` inside `table`. Creates an empty one if it does not exist.
Value& find_or_create_table(Value& table, const std::string& key, const FileLocation& location) {
    for (Value& item : table.items) {
        if (item.key != key) continue;
        if (item.kind != Value::Kind::table)
            throw InputError(location, key + " = " + to_toml(item) + " is not a table, so no key below it can be set");
        return item;
    }
    Value entry;
    entry.key = key;
    entry.location = entry.key_location = location;
    table.items.push_back(entry);
    return table.items.back();
}

void erase(Value& table, const std::string& key) {
    std::erase_if(table.items, [&](const Value& item) { return item.key == key; });
}

/// Removes from `table` the keys of paints that must not be stated together with the key of the override `entry`. For
/// example, an override of `texture` removes `color`. An override `checker = false` removes nothing.
void erase_other_paints(Value& table, const Value& entry) {
    if (entry.kind == Value::Kind::boolean && !entry.boolean) return;
    const auto erase_if_set = [&](std::initializer_list<const char*> set, std::initializer_list<const char*> erased) {
        if (std::none_of(set.begin(), set.end(), [&](const char* key) { return entry.key == key; })) return;
        for (const char* key : erased) erase(table, key);
    };
    erase_if_set({"texture", "temperature"}, {"color", "checker"});
    erase_if_set({"color", "checker", "temperature"}, {"texture"});
    erase_if_set({"color", "checker", "texture"}, {"temperature"});
}

/// Removes from the table [camera] the key of the file that must not be stated together with the key of the override
/// `entry`: `observer` or `velocity`. Keys of other overrides are kept, so that stating both is an error.
void erase_other_motion(Value& camera, const Value& entry) {
    const std::string other = entry.key == "velocity" ? "observer" : entry.key == "observer" ? "velocity" : "";
    std::erase_if(camera.items, [&](const Value& item) { return item.key == other && item.location.line > 0; });
}

}  // namespace

std::vector<std::string> keys_of_path(const std::string& path, const FileLocation& location) {
    std::size_t equals = 0;
    return split_path(path.find('=') == std::string::npos ? path + '=' : path, equals, location);
}

void set_value(Value& root, const std::vector<std::string>& path, Value value, const FileLocation& location) {
    Value* table = &root;
    std::size_t first_key = 0;  // index in `path` of the first key below `table`
    if (path[0] == "object" || path[0] == "medium") {
        if (path.size() < 3)
            throw InputError(location, "an override of " + std::string(path[0] == "object" ? "an " : "a ") + path[0] +
                                           " has the form " + path[0] + ".NAME.key=value");
        table = &table_named(root, path[0], path[1], location);
        first_key = 2;
    }
    for (std::size_t i = first_key; i + 1 < path.size(); ++i) table = &find_or_create_table(*table, path[i], location);
    value.key = path.back();
    if (path[0] == "object" || path[0] == "sky") erase_other_paints(*table, value);
    if (path[0] == "camera") erase_other_motion(*table, value);
    // An existing key keeps its position in the table, because a formula in [space.let] may use the names before it.
    const auto old = std::find_if(table->items.begin(), table->items.end(),
                                  [&](const Value& item) { return item.key == value.key; });
    if (old != table->items.end()) *old = value;
    else table->items.push_back(value);
}

void apply_override(Value& root, const std::string& override_text, const std::string& option) {
    constexpr std::size_t max_length = 100;  // bytes; a formula may be long
    const FileLocation location{option.size() > max_length ? option.substr(0, max_length) + "…" : option, 0, 0};
    std::size_t equals = 0;
    const std::vector<std::string> path = split_path(override_text, equals, location);
    set_value(root, path, parse_toml_value(trimmed(override_text.substr(equals + 1)), location), location);
}

}  // namespace kagero
