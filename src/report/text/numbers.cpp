#include "report/text/numbers.h"

#include <charconv>
#include <cmath>

namespace kagero {

void append_exact(std::string& text, double value) {
    char buffer[40];
    if (std::isnan(value)) value = std::abs(value);  // Clears the sign bit, so that the text is never "-nan".
    const auto end = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::general, 17).ptr;
    text.append(buffer, end);
}

std::string shortest(double value) {
    char buffer[40];
    return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr};
}

std::string fixed(double value, int digits) {
    char buffer[400];  // The largest double has 309 digits before the decimal point.
    return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, digits).ptr};
}

std::string rounded(double value) {
    if (!std::isfinite(value)) return shortest(value);
    const char* suffix = "";
    for (const char* next : {" k", " M", " G"}) {
        if (std::abs(value) < 999.5) break;  // From 999.5 on, rounding to three digits gives 1000.
        value /= 1000;
        suffix = next;
    }
    char buffer[40];
    return std::string(buffer,
                       std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::general, 3).ptr) +
           suffix;
}

}  // namespace kagero
