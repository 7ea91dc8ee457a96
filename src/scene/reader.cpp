#include "scene/reader.h"

#include "error.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace kagero {

namespace {

std::string join(const std::vector<std::string>& words) {
    std::string text;
    for (const std::string& word : words) append_to_list(text, word);
    return text;
}

std::string range_text(const Range& range) {
    const std::string least = to_toml(range.least) + (range.least_open ? " < " : " <= ");
    const std::string greatest = (range.greatest_open ? " < " : " <= ") + to_toml(range.greatest);
    const bool bounded_below = std::isfinite(range.least), bounded_above = std::isfinite(range.greatest);
    if (!bounded_below && !bounded_above) return "any finite number";
    return (bounded_below ? least : "") + "value" + (bounded_above ? greatest : "");
}

/// Converts an array of `count` numbers, at most three; the other elements of the result are 0.
std::array<double, 3> to_numbers(const Value& value, const std::string& name, const Range& range, std::size_t count) {
    const std::string expected = "an array of " + std::to_string(count) + " numbers";
    if (value.kind != Value::Kind::array || value.items.size() != count) fail(value, name, expected);
    std::array<double, 3> result{};
    for (std::size_t i = 0; i < count; ++i) {
        result[i] = to_number(value.items[i], name + '[' + std::to_string(i) + ']', range);
    }
    return result;
}

}  // namespace

Section section(const Value& root, const std::string& key) {
    const Value* table = find(root, key);
    if (!table) return {nullptr, key, {root.location.file, 1, 1}};
    if (table->kind != Value::Kind::table) fail(*table, key, "a table: [" + key + "]");
    return {table, key, table->location};
}

Section subsection(const Section& section, const std::string& key) {
    const Value* table = find(section, key);
    if (table && table->kind != Value::Kind::table)
        fail(*table, full_name(section, key), "a table: [" + full_name(section, key) + "]");
    return {table, full_name(section, key), table ? table->location : section.location};
}

std::string full_name(const Section& section, const std::string& key) {
    return section.name.empty() ? key : section.name + '.' + key;
}

void fail(const Value& value, const std::string& name, const std::string& expected) {
    throw InputError(value.location, name + " = " + to_toml(value) + " is not legal: it must be " + expected);
}

std::string suggestion(const std::string& word, const std::vector<std::string>& known) {
    const std::string near = near_match(word, known);
    std::string text;
    if (!near.empty()) text += "; did you mean " + to_toml(near) + '?';
    if (!known.empty()) text += (near.empty() ? "; legal names: " : " Legal names: ") + join(known);
    return text;
}

const Value* find(const Section& section, const std::string& key) {
    return section.table ? find(*section.table, key) : nullptr;
}

const Value& require(const Section& section, const std::string& key) {
    if (const Value* value = find(section, key)) return *value;
    throw InputError(section.location, "the required key " + full_name(section, key) + " is missing");
}

const Value& require_type_key(const Section& section, const std::string& key) {
    if (section.table && !find(section, key))
        for (const Value& item : section.table->items)
            if (!near_match(item.key, {key}).empty())
                throw InputError(item.key_location, "unknown key " + full_name(section, item.key) + "; did you mean " +
                                                     to_toml(key) + '?');
    return require(section, key);
}

void check_keys(const Section& section, const std::vector<std::string>& known) {
    if (!section.table) return;
    for (const Value& item : section.table->items) {
        if (std::find(known.begin(), known.end(), item.key) != known.end()) continue;
        throw InputError(item.key_location,
                         "unknown key " + full_name(section, item.key) + suggestion(item.key, known));
    }
}

double to_number(const Value& value, const std::string& name, const Range& range) {
    const bool numeric = value.kind == Value::Kind::number || value.kind == Value::Kind::integer;
    if (!numeric) fail(value, name, "a number");
    if (!std::isfinite(value.number)) fail(value, name, "a finite number");
    const bool above_least = range.least_open ? value.number > range.least : value.number >= range.least;
    const bool below_greatest = range.greatest_open ? value.number < range.greatest : value.number <= range.greatest;
    if (!above_least || !below_greatest) {
        throw InputError(value.location,
                         name + " = " + to_toml(value) + " is out of range: the legal range is " + range_text(range));
    }
    return value.number;
}

Double3 to_double3(const Value& value, const std::string& name, const Range& range) {
    return to_numbers(value, name, range, 3);
}

std::array<double, 2> to_double2(const Value& value, const std::string& name, const Range& range) {
    const auto pair = to_numbers(value, name, range, 2);
    return {pair[0], pair[1]};
}

std::uint32_t to_count(const Value& value, const std::string& name, std::uint32_t least, std::uint32_t greatest) {
    const Range range{static_cast<double>(least), static_cast<double>(greatest)};
    if (value.kind != Value::Kind::integer) {
        const bool whole = value.kind == Value::Kind::number && value.number == std::floor(value.number);
        fail(value, name, "a whole number with " + range_text(range) + (whole ? ", without a decimal point" : ""));
    }
    if (!(value.number >= range.least && value.number <= range.greatest))
        throw InputError(value.location,
                         name + " = " + to_toml(value) + " is out of range: the legal range is " + range_text(range));
    return static_cast<std::uint32_t>(value.number);
}

const std::string& to_text(const Value& value, const std::string& name) {
    if (value.kind != Value::Kind::string) fail(value, name, "a string");
    return value.string;
}

std::size_t to_choice(const Value& value, const std::string& name, const std::vector<std::string>& words) {
    const std::string& text = to_text(value, name);
    const auto found = std::find(words.begin(), words.end(), text);
    if (found != words.end()) return static_cast<std::size_t>(found - words.begin());
    throw InputError(value.location, name + " = " + to_toml(text) + " is not a legal value" + suggestion(text, words));
}

void read(const Section& section, const std::string& key, double& target, const Range& range) {
    if (const Value* value = find(section, key)) target = to_number(*value, full_name(section, key), range);
}

void read(const Section& section, const std::string& key, Double3& target, const Range& range) {
    if (const Value* value = find(section, key)) target = to_double3(*value, full_name(section, key), range);
}

std::string to_file(const Value& value, const std::string& name, const std::string& directory) {
    namespace fs = std::filesystem;
    const std::string& stated = to_text(value, name);
    if (stated.empty()) fail(value, name, "the path of a file");
    std::error_code error;
    const fs::path path = fs::absolute(fs::path(directory) / stated).lexically_normal();
    if (fs::is_regular_file(path, error)) return path.string();
    std::string message = name + " = " + to_toml(stated) + ": ";
    message += fs::is_directory(path, error) ? path.string() + " is a directory, not a file"
               : fs::exists(path, error)     ? path.string() + " is a device, a pipe or a socket, not a file"
                                             : "there is no file " + path.string();
    if (path.string().rfind("/usr/share/assimp/models/", 0) == 0)
        message += "; on Debian, install the package assimp-testmodels";
    throw InputError(value.location, message);
}

}  // namespace kagero
