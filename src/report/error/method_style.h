/// Colours and marks of methods. They are the same in every chart; methods of one family have similar hues and the same
/// mark.
#pragma once

#include "kernels/abi.h"
#include "report/text/chart.h"

#include <vector>

namespace kagero {

/// Colour and mark of one method.
struct MethodStyle {
    std::string color;  ///< CSS colour.
    Mark mark;
};

/// Returns the style of a method. It depends only on the name and the family of the method.
MethodStyle style_of(const IntegratorInfo& method);

/// Colour and mark of one family of methods.
struct FamilyStyle {
    MethodFamily family;
    const char* name;
    int hue, saturation;  ///< Degrees and per cent, as in CSS hsl().
    Mark mark;
    /// Returns a CSS colour. `hue_shift` (degrees) and `lightness` (per cent) distinguish methods of the same family.
    std::string color(int hue_shift = 0, int lightness = 42) const;
};
/// Returns the styles of all families, in the order of the legend.
const std::vector<FamilyStyle>& family_styles();

}  // namespace kagero
