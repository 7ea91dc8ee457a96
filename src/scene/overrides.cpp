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

/// Splits `object."left wall".color` at its dots; keys may be quoted. `end` becomes the position of the '='.
std::vector<std::string> split_path(const std::string& text, std::size_t& end, const Place& place) {
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
    const bool named = std::none_of(path.begin(), path.end(), [](const std::string& key) { return key.empty(); });
    if (end == text.size() || !named) throw InputError(place, "expected key.path=value, for example space.rg=0.1");
    return path;
}

/// The object of a name; objects without one are called object-1, object-2 … by their position.
Value& object_named(Value& root, const std::string& name, const Place& place) {
    std::vector<std::string> names;
    for (Value& item : root.items) {
        if (item.key != "object" || item.kind != Value::Kind::array) continue;
        for (Value& object : item.items) {
            const Value* given = find(object, "name");
            const bool has_name = given && given->kind == Value::Kind::string;
            names.push_back(has_name ? given->string : "object-" + std::to_string(names.size() + 1));
            if (names.back() == name) return object;
        }
    }
    std::string message = "there is no object " + written(name);
    const std::string near = near_match(name, names);
    if (!near.empty()) message += "; did you mean " + written(near) + '?';
    message += names.empty() ? "; the scene has no objects" : "; objects:";
    for (const std::string& known : names) message += ' ' + known;
    throw InputError(place, message);
}

Value& table_entry(Value& table, const std::string& key, const Place& place) {
    for (Value& item : table.items) {
        if (item.key != key) continue;
        if (item.kind != Value::Kind::table) throw InputError(place, key + " is not a table: it is " + written(item));
        return item;
    }
    Value entry;
    entry.key = key;
    entry.place = entry.key_place = place;
    table.items.push_back(entry);
    return table.items.back();
}

void erase(Value& table, const std::string& key) {
    std::erase_if(table.items, [&](const Value& item) { return item.key == key; });
}

/// A paint given on the command line replaces the one in the file instead of contradicting it; no checker is none.
void erase_other_paints(Value& table, const Value& paint) {
    if (paint.kind == Value::Kind::boolean && !paint.boolean) return;
    const auto replaces = [&](std::initializer_list<const char*> paints, std::initializer_list<const char*> others) {
        if (std::none_of(paints.begin(), paints.end(), [&](const char* one) { return paint.key == one; })) return;
        for (const char* other : others) erase(table, other);
    };
    replaces({"texture", "temperature"}, {"color", "checker"});
    replaces({"color", "checker", "temperature"}, {"texture"});
    replaces({"color", "checker", "texture"}, {"temperature"});
}

}  // namespace

void apply_override(Value& root, const std::string& override_text, const std::string& said) {
    constexpr std::size_t shown = 100;  // of a formula, which may be long
    const Place place{said.size() > shown ? said.substr(0, shown) + "…" : said, 0, 0};
    std::size_t equals = 0;
    std::vector<std::string> path = split_path(override_text, equals, place);
    Value value = parse_toml_value(trimmed(override_text.substr(equals + 1)), place);

    Value* table = &root;
    std::size_t first = 0;
    if (path[0] == "object") {
        if (path.size() < 3) throw InputError(place, "expected object.NAME.key=value");
        table = &object_named(root, path[1], place);
        first = 2;
    }
    for (std::size_t i = first; i + 1 < path.size(); ++i) table = &table_entry(*table, path[i], place);
    value.key = path.back();
    if (path[0] == "object" || path[0] == "sky") erase_other_paints(*table, value);
    // In its old place: the helpers of a formula use those before them.
    const auto old = std::find_if(table->items.begin(), table->items.end(),
                                  [&](const Value& item) { return item.key == value.key; });
    if (old != table->items.end()) *old = value;
    else table->items.push_back(value);
}

}  // namespace kagero
