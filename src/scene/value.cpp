#include "scene/value.h"

#include <charconv>
#include <cmath>

namespace kagero {

const Value* find(const Value& table, const std::string& key) {
    for (const Value& item : table.items) {
        if (item.key == key) return &item;
    }
    return nullptr;
}

std::string to_toml(double number) {
    if (std::isnan(number)) return "nan";
    if (std::isinf(number)) return number < 0 ? "-inf" : "inf";
    if (number == 0 && std::signbit(number)) return "-0.0";  // TOML would read -0 as the integer 0
    char buffer[40];
    // Whole numbers have no exponent (100000 instead of 1e+05) as long as all their digits are significant.
    const bool whole = number == std::floor(number) && std::abs(number) < 1e15;
    const auto result = whole ? std::to_chars(buffer, buffer + sizeof buffer, number, std::chars_format::fixed)
                              : std::to_chars(buffer, buffer + sizeof buffer, number);
    return {buffer, result.ptr};
}

std::string to_toml(const std::string& text) {
    static const char digits[] = "0123456789abcdef";
    std::string out = "\"";
    for (const char letter : text) {
        const auto code = static_cast<unsigned char>(letter);
        if (letter == '"' || letter == '\\') {
            out += {'\\', letter};
        } else if (letter == '\n') {
            out += "\\n";
        } else if (letter == '\t') {
            out += "\\t";
        } else if (code < 0x20 || code == 0x7f) {
            out += {'\\', 'u', '0', '0', digits[code / 16], digits[code % 16]};
        } else {
            out += letter;
        }
    }
    return out + '"';
}

std::string to_toml(const Value& value) {
    switch (value.kind) {
        case Value::Kind::boolean:
            return value.boolean ? "true" : "false";
        case Value::Kind::integer:
            return std::to_string(value.integer);
        case Value::Kind::number:
            return to_toml(value.number);
        case Value::Kind::string:
            return to_toml(value.string);
        case Value::Kind::other:
            return "a " + value.string;
        case Value::Kind::array:
        case Value::Kind::table:
            break;
    }
    const bool is_table = value.kind == Value::Kind::table;
    std::string out;
    for (const Value& item : value.items) {
        if (!out.empty()) out += ", ";
        if (is_table) out += item.key + " = ";
        out += to_toml(item);
    }
    return is_table ? "{ " + out + " }" : "[" + out + "]";
}

}  // namespace kagero
