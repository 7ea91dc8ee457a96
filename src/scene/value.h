/// A TOML document as a plain tree: toml++ stays in one file, and overrides are merged before anything is read.
#pragma once

#include "error.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace kagero {

/// A value with the place it was written at.
struct Value {
    enum class Kind { boolean, integer, number, string, array, table, other };
    Kind kind = Kind::table;
    bool boolean = false;
    std::int64_t integer = 0;
    double number = 0;         ///< of an integer too
    std::string string;        ///< of a string; of `other` (dates, times) what it is
    std::vector<Value> items;  ///< of an array; of a table, with their keys, in the order of the file
    std::string key;           ///< in the table that holds it
    Place place, key_place;
};

/// The entry of a table, or null.
const Value* find(const Value& table, const std::string& key);

/// As TOML; a double in the shortest form that reads back as the same number.
std::string written(double number);
std::string written(const std::string& text);
std::string written(const Value& value);
template <std::size_t n>
std::string written(const std::array<double, n>& numbers) {
    std::string list;
    for (const double number : numbers) enumerate(list, written(number));
    return '[' + list + ']';
}

}  // namespace kagero
