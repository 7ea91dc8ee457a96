/// How methods look in every chart: families share a hue and a mark, whatever else is drawn beside them.
#pragma once

#include "kernels/abi.h"
#include "report/text/chart.h"

#include <vector>

namespace kagero {

struct MethodStyle {
    std::string color;  ///< CSS
    Mark mark;
};

MethodStyle style_of(const IntegratorInfo& method);

struct FamilyStyle {
    Family family;
    const char* name;
    int hue, saturation;
    Mark mark;
    /// CSS; shades around the family's own tell siblings apart.
    std::string color(int hue_shift = 0, int lightness = 42) const;
};
/// Of all families, in the order in which they are told.
const std::vector<FamilyStyle>& family_styles();

}  // namespace kagero
