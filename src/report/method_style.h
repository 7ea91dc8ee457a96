/// How methods look in every chart: families share a hue and a mark, whatever else is drawn beside them.
#pragma once

#include "report/chart.h"

namespace kagero {

struct MethodStyle {
    std::string color;  ///< CSS
    Mark mark;
};

MethodStyle style_of(const std::string& method);

bool same_family(const std::string& a, const std::string& b);

/// What the families are called, with one method of each to ask for its style.
struct MethodFamily {
    const char* name;
    const char* example;
};
const std::vector<MethodFamily>& method_families();

}  // namespace kagero
