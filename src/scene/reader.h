/// Strict reading of tables: every value has a type, a legal range and a place; whatever is left over is an error.
#pragma once

#include "scene/description.h"
#include "scene/value.h"

namespace kagero {

/// A table with the name that messages give it ("camera", "object.floor"). `table` is null where the file has none.
struct Section {
    const Value* table;
    std::string name;
    Place place;
};

/// Legal values of a number: least ≤ value ≤ greatest, without the ends that are open.
struct Range {
    double least, greatest;
    bool least_open = false, greatest_open = false;
};

/// Lengths in scene units. Embree aborts beyond 1.8e18, so what a scene may name stays well below.
inline constexpr Range any_length{-1e12, 1e12};
inline constexpr Range positive_length{0, 1e12, true};
inline constexpr Range any_angle{-36000, 36000};

/// The table `key` of a document; not there is not an error.
Section section(const Value& root, const std::string& key);

/// "camera.fov", "object.floor.radius": the path that -D takes.
std::string full_name(const Section& section, const std::string& key);

[[noreturn]] void fail(const Value& value, const std::string& name, const std::string& expected);
/// "; did you mean "x"? known: a, b, c"
std::string suggestion(const std::string& word, const std::vector<std::string>& known);

const Value* find(const Section& section, const std::string& key);
/// Throws unless the key is there.
const Value& need(const Section& section, const std::string& key);
/// The same of a key that tells which others there may be: where it is missing, one that looks like it is taken for a
/// slip.
const Value& need_kind(const Section& section, const std::string& key);
/// Throws if the table has any other key.
void only_keys(const Section& section, const std::vector<std::string>& known);

// A value of the type wanted. Throws InputError at the value's place, with its `name` and what is legal, for any other
// type and outside of it.
double to_number(const Value& value, const std::string& name, const Range& range);
Double3 to_double3(const Value& value, const std::string& name, const Range& range);
std::array<double, 2> to_double2(const Value& value, const std::string& name, const Range& range);
std::uint32_t to_count(const Value& value, const std::string& name, std::uint32_t least, std::uint32_t greatest);
const std::string& to_text(const Value& value, const std::string& name);
/// The index of a string in a list of words.
std::size_t to_choice(const Value& value, const std::string& name, const std::vector<std::string>& words);

// The same for a key that may be absent: the target keeps its value then.
void read(const Section& section, const std::string& key, double& target, const Range& range);
void read(const Section& section, const std::string& key, Double3& target, const Range& range);

/// An absolute path to an existing file; relative ones start at `directory`. Throws InputError where there is no such
/// file.
std::string to_file(const Value& value, const std::string& name, const std::string& directory);

}  // namespace kagero
