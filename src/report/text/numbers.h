/// Numbers as text, the same in every locale.
#pragma once

#include <string>

namespace kagero {

/// 17 significant digits: reading them back gives the same double.
void append_exact(std::string& text, double value);
/// The shortest text that reads back as the same double.
std::string shortest(double value);
/// So many digits behind the point.
std::string fixed(double value, int digits = 1);
/// Three significant digits with a thousands suffix, for people: 2.71 M.
std::string rounded(double value);

/// 0 where b is not greater than 0.
inline double ratio(double a, double b) {
    return b > 0 ? a / b : 0;
}

}  // namespace kagero
