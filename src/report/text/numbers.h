/// Conversions of numbers to text that do not depend on the locale.
#pragma once

#include <string>

namespace kagero {

/// Appends 17 significant digits, which determine the double exactly. Every NaN becomes "nan".
void append_exact(std::string& text, double value);
/// Returns the shortest text that is parsed as the same double.
std::string shortest(double value);
/// Returns fixed notation with this number of digits after the decimal point.
std::string fixed(double value, int digits = 1);
/// Returns three significant digits with the suffix k, M or G where needed, such as "2.71 M".
std::string rounded(double value);

/// Returns a / b, or 0 if b is not greater than 0.
inline double ratio(double a, double b) { return b > 0 ? a / b : 0; }

}  // namespace kagero
