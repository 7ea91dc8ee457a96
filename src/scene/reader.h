/// Strict reading of tables. Every value has a type, a legal range and a position in the file. Unknown keys are errors.
#pragma once

#include "scene/description.h"
#include "scene/value.h"

namespace kagero {

/// A table of a scene file.
struct Section {
    const Value* table;     ///< Null if the file does not contain the table.
    std::string name;       ///< Name in messages, such as "camera" or "object.floor".
    FileLocation location;  ///< Position of the table, or line 1 of the file.
};

/// Legal range of a number: least ≤ value ≤ greatest. If an end is open, the bound itself is not legal.
struct Range {
    double least, greatest;
    bool least_open = false, greatest_open = false;
};

/// Ranges of lengths in scene units and of angles in degrees. Embree aborts at coordinates beyond 1.8e18; the limit
/// 1e12 is far below that.
inline constexpr Range any_length{-1e12, 1e12};
inline constexpr Range positive_length{0, 1e12, true};
inline constexpr Range any_angle{-36000, 36000};

/// Returns the table `key` of a document. A missing table is not an error.
Section section(const Value& root, const std::string& key);
/// Returns the table `key` inside a section. A missing table is not an error.
Section subsection(const Section& section, const std::string& key);

/// Returns the full name of a key, as in the option -D: "camera.fov" or "object.floor.radius".
std::string full_name(const Section& section, const std::string& key);

/// Throws InputError at the position of the value. `name` is the full name of its key, and `expected` describes the
/// legal values, such as "a number".
[[noreturn]] void fail(const Value& value, const std::string& name, const std::string& expected);
/// Returns the end of a message about an unknown word, such as "; did you mean "x"? Legal names: x, y, z".
std::string suggestion(const std::string& word, const std::vector<std::string>& known);

/// Returns the value of a key, or nullptr if the key is missing.
const Value* find(const Section& section, const std::string& key);
/// Returns the value of a key. Throws InputError if the key is missing.
const Value& require(const Section& section, const std::string& key);
/// Returns the value of a key that selects the type of a table, such as `shape`, and with it the other legal keys. If
/// the key is missing but a similar key exists, the InputError reports the similar key as a misspelling.
const Value& require_type_key(const Section& section, const std::string& key);
/// Throws InputError if the table has a key that is not in `known`.
void check_keys(const Section& section, const std::vector<std::string>& known);

// The following functions convert a value to a type. They throw InputError at the position of the value if it has
// another type or is outside the legal range. `name` is the full name of the key, for the message. The bounds of
// to_count are inclusive.
double to_number(const Value& value, const std::string& name, const Range& range);
Double3 to_double3(const Value& value, const std::string& name, const Range& range);
std::array<double, 2> to_double2(const Value& value, const std::string& name, const Range& range);
std::uint32_t to_count(const Value& value, const std::string& name, std::uint32_t least, std::uint32_t greatest);
const std::string& to_text(const Value& value, const std::string& name);
/// Returns the index of a string in a list of words.
std::size_t to_choice(const Value& value, const std::string& name, const std::vector<std::string>& words);

// The following functions read an optional key. The target keeps its value if the key is missing.
void read(const Section& section, const std::string& key, double& target, const Range& range);
void read(const Section& section, const std::string& key, Double3& target, const Range& range);

/// Returns the absolute path of an existing file. Relative paths start at `directory`. Throws InputError if there is no
/// such file.
std::string to_file(const Value& value, const std::string& name, const std::string& directory);

}  // namespace kagero
