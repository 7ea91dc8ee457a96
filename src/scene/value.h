/// A TOML document as a tree of values. Overrides are merged into the tree before the scene is read. The tree does not
/// use types of toml++, so only toml.cpp includes toml++.
#pragma once

#include "error.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace kagero {

/// A value with its position in the file.
struct Value {
    enum class Kind { boolean, integer, number, string, array, table, other };
    Kind kind = Kind::table;
    bool boolean = false;
    std::int64_t integer = 0;
    double number = 0;         ///< Value of a number or an integer.
    std::string string;        ///< Text of a string; name of the type for `other` (dates and times).
    std::vector<Value> items;  ///< Elements of an array; entries of a table, with their keys, in the order of the file.
    std::string key;           ///< Key in the enclosing table.
    FileLocation location, key_location;  ///< Positions of the value and of its key.
};

/// Returns the entry of a table with this key, or nullptr.
const Value* find(const Value& table, const std::string& key);

/// Returns the value as TOML text. A double has the shortest form that is read back as the same number.
std::string to_toml(double number);
std::string to_toml(const std::string& text);
std::string to_toml(const Value& value);
template <std::size_t n>
std::string to_toml(const std::array<double, n>& numbers) {
    std::string list;
    for (const double number : numbers) append_to_list(list, to_toml(number));
    return '[' + list + ']';
}

}  // namespace kagero
