// This is the only file that includes toml++.
#include "scene/toml.h"

#include <toml++/toml.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <regex>
#include <sstream>

namespace kagero {

namespace {

FileLocation location_of(const toml::source_region& region, const std::string& file) {
    return {file, static_cast<int>(region.begin.line), static_cast<int>(region.begin.column)};
}

Value convert(const toml::node& node, const std::string& file);

void convert_table(const toml::table& table, const std::string& file, Value& value) {
    value.kind = Value::Kind::table;
    for (const auto& [key, item] : table) {
        value.items.push_back(convert(item, file));
        value.items.back().key = std::string(key.str());
        value.items.back().key_location = location_of(key.source(), file);
    }
    // toml++ sorts entries by key. Sorting by position lets errors be reported in the order of the file.
    std::stable_sort(value.items.begin(), value.items.end(), [](const Value& a, const Value& b) {
        return std::pair(a.key_location.line, a.key_location.column) <
               std::pair(b.key_location.line, b.key_location.column);
    });
}

Value convert(const toml::node& node, const std::string& file) {
    Value value;
    value.location = location_of(node.source(), file);
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

void set_location(Value& value, const FileLocation& location) {
    value.location = value.key_location = location;
    for (Value& item : value.items) set_location(item, location);
}

/// Returns the position after the TOML string that begins at `i`. A string is delimited by one or three quotes, single
/// or double.
std::size_t end_of_string(const std::string& text, std::size_t i) {
    const char quote = text[i];
    const std::string delimiter(text.compare(i, 3, std::string(3, quote)) == 0 ? 3 : 1, quote);
    for (i += delimiter.size(); i < text.size(); ++i) {
        if (text.compare(i, delimiter.size(), delimiter) == 0) return i + delimiter.size();
        if (quote == '"' && text[i] == '\\') ++i;
        if (delimiter.size() == 1 && i < text.size() && text[i] == '\n') return i;  // the string is not closed
    }
    return text.size();
}

/// Throws InputError if a key has too many parts. toml++ creates one nested table for each part of a key and destroys
/// the tables recursively, so that thousands of parts exhaust the stack.
void check_depth_of_keys(const std::string& text, FileLocation location) {
    constexpr int max_parts = 32;
    int parts = 1;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (c == '"' || c == '\'') {
            const std::size_t end = end_of_string(text, i);
            location.line += static_cast<int>(
                std::count(text.begin() + std::ptrdiff_t(i), text.begin() + std::ptrdiff_t(end), '\n'));
            i = end - 1;
            continue;
        }
        if (c == '#') i = std::min(text.find('\n', i), text.size()) - 1;
        else if (c == '\n') {
            ++location.line;
            parts = 1;
        } else if (c == '.') ++parts;
        else if (!std::isalnum(static_cast<unsigned char>(c)) && !std::strchr("_- \t", c)) parts = 1;
        if (parts > max_parts)
            throw InputError(location,
                             "a key has more than " + std::to_string(max_parts) +
                                 " parts; keys of scene files have at most 3 parts");
    }
}

/// Returns true if the text contains no character that has a meaning in TOML. It may then be a string without quotes.
bool is_bare_word(const std::string& text) {
    return !text.empty() && text.find_first_of("[]{}\"'=,#\n\r") == std::string::npos;
}

/// Returns the text with a digit before and after every decimal point of a number, as TOML requires: `.20` becomes
/// `0.20`, and `5.` becomes `5.0`. Text in quotes is not changed.
std::string with_complete_numbers(const std::string& text) {
    if (text.find_first_of("\"'") != std::string::npos) return text;
    static const std::regex no_digit_before("(^|[-+\\s,\\[=])\\.(\\d)"), no_digit_after("(\\d)\\.(?=$|[\\s,\\]eE])");
    return std::regex_replace(std::regex_replace(text, no_digit_before, "$010.$2"), no_digit_after, "$1.0");
}

/// Returns a hint if a line of the file contains a number that TOML refuses; else "".
std::string hint_about_numbers(const std::string& text, int line) {
    std::istringstream lines(text);
    std::string content;
    for (int i = 0; i < line && std::getline(lines, content); ++i) {}
    const std::string complete = with_complete_numbers(content);
    return complete == content ? "" : "; numbers need a digit before and after the point: " + complete;
}

}  // namespace

Value parse_toml(const std::string& text, const std::string& file) {
    check_depth_of_keys(text, {file, 1, 0});
    try {
        return convert(toml::parse(text, file), file);
    } catch (const toml::parse_error& error) {
        throw InputError(location_of(error.source(), file),
                         std::string(error.description()) +
                             hint_about_numbers(text, static_cast<int>(error.source().begin.line)));
    }
}

Value parse_toml_value(const std::string& text, const FileLocation& location) {
    Value value;
    if (text.empty()) throw InputError(location, "the value after '=' is missing; write KEY=VALUE");
    check_depth_of_keys(text, location);
    try {
        const Value document = convert(toml::parse("value = " + with_complete_numbers(text)), "");
        if (document.items.size() != 1)
            throw InputError(location,
                             "there is more than one value after '='; use one option -D KEY=VALUE for each key");
        value = document.items.front();
    } catch (const toml::parse_error& error) {
        if (!is_bare_word(text))
            throw InputError(location, std::string(error.description()) +
                                        "; put text with commas, brackets or quotes in quotes: 'KEY=\"TEXT\"'");
        value.kind = Value::Kind::string;
        value.string = text;
    }
    set_location(value, location);
    return value;
}

}  // namespace kagero
