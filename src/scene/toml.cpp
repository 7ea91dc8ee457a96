// The only file that includes toml++.
#include "scene/toml.h"

#include <toml++/toml.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <sstream>

namespace kagero {

namespace {

Place place_of(const toml::source_region& region, const std::string& file) {
    return {file, static_cast<int>(region.begin.line), static_cast<int>(region.begin.column)};
}

Value convert(const toml::node& node, const std::string& file);

void convert_table(const toml::table& table, const std::string& file, Value& value) {
    value.kind = Value::Kind::table;
    for (const auto& [key, item] : table) {
        value.items.push_back(convert(item, file));
        value.items.back().key = std::string(key.str());
        value.items.back().key_place = place_of(key.source(), file);
    }
    // toml++ sorts by key; errors should come in the order of the file.
    std::stable_sort(value.items.begin(), value.items.end(), [](const Value& a, const Value& b) {
        return std::pair(a.key_place.line, a.key_place.column) < std::pair(b.key_place.line, b.key_place.column);
    });
}

Value convert(const toml::node& node, const std::string& file) {
    Value value;
    value.place = place_of(node.source(), file);
    if (const auto* table = node.as_table()) {
        convert_table(*table, file, value);
    } else if (const auto* array = node.as_array()) {
        value.kind = Value::Kind::array;
        for (const auto& item : *array) value.items.push_back(convert(item, file));
    } else if (const auto* string = node.as_string()) {
        value.kind = Value::Kind::string;
        value.string = string->get();
    } else if (const auto* integer = node.as_integer()) {
        value.kind = Value::Kind::integer;
        value.integer = integer->get();
        value.number = static_cast<double>(value.integer);
    } else if (const auto* number = node.as_floating_point()) {
        value.kind = Value::Kind::number;
        value.number = number->get();
    } else if (const auto* boolean = node.as_boolean()) {
        value.kind = Value::Kind::boolean;
        value.boolean = boolean->get();
    } else {
        value.kind = Value::Kind::other;
        std::ostringstream text;
        text << node.type();
        value.string = text.str();
    }
    return value;
}

void set_place(Value& value, const Place& place) {
    value.place = value.key_place = place;
    for (Value& item : value.items) set_place(item, place);
}

/// Past the string that begins at `i`, in any of the four ways that TOML writes them.
std::size_t end_of_string(const std::string& text, std::size_t i) {
    const char quote = text[i];
    const std::string whole(text.compare(i, 3, std::string(3, quote)) == 0 ? 3 : 1, quote);
    for (i += whole.size(); i < text.size(); ++i) {
        if (text.compare(i, whole.size(), whole) == 0) return i + whole.size();
        if (quote == '"' && text[i] == '\\') ++i;
        if (whole.size() == 1 && i < text.size() && text[i] == '\n') return i;  // not closed
    }
    return text.size();
}

/// toml++ makes a table of every part of a key, and takes them down one inside the other: thousands of parts exhaust
/// the stack.
void check_depth_of_keys(const std::string& text, Place place) {
    constexpr int most_parts = 32;
    int parts = 1;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (c == '"' || c == '\'') {
            const std::size_t end = end_of_string(text, i);
            place.line += static_cast<int>(
                std::count(text.begin() + std::ptrdiff_t(i), text.begin() + std::ptrdiff_t(end), '\n'));
            i = end - 1;
            continue;
        }
        if (c == '#') i = std::min(text.find('\n', i), text.size()) - 1;
        else if (c == '\n') ++place.line, parts = 1;
        else if (c == '.') ++parts;
        else if (!std::isalnum(static_cast<unsigned char>(c)) && !std::strchr("_- \t", c)) parts = 1;
        if (parts > most_parts)
            throw InputError(place,
                             "a key of more than " + std::to_string(most_parts) + " parts; a scene's have up to 3");
    }
}

bool is_bare_word(const std::string& text) {
    return !text.empty() && text.find_first_of("[]{}\"'=,#\n\r") == std::string::npos;
}

}  // namespace

Value parse_toml(const std::string& text, const std::string& file) {
    check_depth_of_keys(text, {file, 1, 0});
    try {
        return convert(toml::parse(text, file), file);
    } catch (const toml::parse_error& error) {
        throw InputError(place_of(error.source(), file), std::string(error.description()));
    }
}

Value parse_toml_value(const std::string& text, const Place& place) {
    Value value;
    if (text.empty()) throw InputError(place, "expected a value after '='");
    check_depth_of_keys(text, place);
    try {
        const Value document = convert(toml::parse("value = " + text), "");
        if (document.items.size() != 1) throw InputError(place, "expected one value after '='");
        value = document.items.front();
    } catch (const toml::parse_error& error) {
        if (!is_bare_word(text))
            throw InputError(place, std::string(error.description()) +
                                        "; words with commas, brackets or quotes go in quotes: 'KEY=\"…\"'");
        value.kind = Value::Kind::string;
        value.string = text;
    }
    set_place(value, place);
    return value;
}

}  // namespace kagero
