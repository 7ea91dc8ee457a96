#include "scene/reader.h"

#include "error.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace kagero {

namespace {

std::string listed(const std::vector<std::string>& words) {
    std::string text;
    for (const std::string& word : words) enumerate(text, word);
    return text;
}

std::string described(const Range& range) {
    const std::string least = written(range.least) + (range.least_open ? " < " : " <= ");
    const std::string greatest = (range.greatest_open ? " < " : " <= ") + written(range.greatest);
    const bool bounded_below = std::isfinite(range.least), bounded_above = std::isfinite(range.greatest);
    if (!bounded_below && !bounded_above) return "any finite number";
    return (bounded_below ? least : "") + "value" + (bounded_above ? greatest : "");
}

std::array<double, 3> numbers(const Value& value, const std::string& name, const Range& range, std::size_t count) {
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
    if (!table) return {nullptr, key, {root.place.file, 1, 1}};
    if (table->kind != Value::Kind::table) fail(*table, key, "a table: [" + key + "]");
    return {table, key, table->place};
}

std::string full_name(const Section& section, const std::string& key) {
    return section.name.empty() ? key : section.name + '.' + key;
}

void fail(const Value& value, const std::string& name, const std::string& expected) {
    throw InputError(value.place, name + " = " + written(value) + ": expected " + expected);
}

std::string suggestion(const std::string& word, const std::vector<std::string>& known) {
    const std::string near = near_match(word, known);
    std::string text;
    if (!near.empty()) text += "; did you mean " + written(near) + '?';
    if (!known.empty()) text += (near.empty() ? "; known: " : " known: ") + listed(known);
    return text;
}

const Value* find(const Section& section, const std::string& key) {
    return section.table ? find(*section.table, key) : nullptr;
}

const Value& need(const Section& section, const std::string& key) {
    if (const Value* value = find(section, key)) return *value;
    throw InputError(section.place, full_name(section, key) + " is missing: it is required");
}

const Value& need_kind(const Section& section, const std::string& key) {
    if (section.table && !find(section, key))
        for (const Value& item : section.table->items)
            if (!near_match(item.key, {key}).empty())
                throw InputError(item.key_place, "unknown key " + full_name(section, item.key) + "; did you mean " +
                                                     written(key) + '?');
    return need(section, key);
}

void only_keys(const Section& section, const std::vector<std::string>& known) {
    if (!section.table) return;
    for (const Value& item : section.table->items) {
        if (std::find(known.begin(), known.end(), item.key) != known.end()) continue;
        throw InputError(item.key_place, "unknown key " + full_name(section, item.key) + suggestion(item.key, known));
    }
}

double to_number(const Value& value, const std::string& name, const Range& range) {
    const bool numeric = value.kind == Value::Kind::number || value.kind == Value::Kind::integer;
    if (!numeric) fail(value, name, "a number");
    if (!std::isfinite(value.number)) fail(value, name, "a finite number");
    const bool above = range.least_open ? value.number > range.least : value.number >= range.least;
    const bool below = range.greatest_open ? value.number < range.greatest : value.number <= range.greatest;
    if (!above || !below) {
        throw InputError(value.place, name + " = " + written(value) + " is out of range: legal is " + described(range));
    }
    return value.number;
}

Double3 to_double3(const Value& value, const std::string& name, const Range& range) {
    return numbers(value, name, range, 3);
}

std::array<double, 2> to_double2(const Value& value, const std::string& name, const Range& range) {
    const auto three = numbers(value, name, range, 2);
    return {three[0], three[1]};
}

std::uint32_t to_count(const Value& value, const std::string& name, std::uint32_t least, std::uint32_t greatest) {
    const Range range{static_cast<double>(least), static_cast<double>(greatest)};
    if (value.kind != Value::Kind::integer) {
        const bool whole = value.kind == Value::Kind::number && value.number == std::floor(value.number);
        fail(value, name, "a whole number, " + described(range) + (whole ? ", written without a point" : ""));
    }
    if (!(value.number >= range.least && value.number <= range.greatest))
        throw InputError(value.place, name + " = " + written(value) + " is out of range: legal is " + described(range));
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
    throw InputError(value.place, name + " = " + written(text) + " is not known" + suggestion(text, words));
}

void read(const Section& section, const std::string& key, double& target, const Range& range) {
    if (const Value* value = find(section, key)) target = to_number(*value, full_name(section, key), range);
}

void read(const Section& section, const std::string& key, Double3& target, const Range& range) {
    if (const Value* value = find(section, key)) target = to_double3(*value, full_name(section, key), range);
}

std::string to_file(const Value& value, const std::string& name, const std::string& directory) {
    namespace fs = std::filesystem;
    const std::string& given = to_text(value, name);
    if (given.empty()) fail(value, name, "the path of a file");
    std::error_code error;
    const fs::path path = fs::absolute(fs::path(directory) / given).lexically_normal();
    if (fs::is_regular_file(path, error)) return path.string();
    std::string message = name + " = " + written(given) + ": ";
    message += fs::is_directory(path, error) ? path.string() + " is a directory"
               : fs::exists(path, error)     ? path.string() + " is a device, a pipe or a socket, not a file"
                                             : "there is no file " + path.string();
    if (path.string().rfind("/usr/share/assimp/models/", 0) == 0)
        message += "; on Debian the package assimp-testmodels brings it";
    throw InputError(value.place, message);
}

}  // namespace kagero
