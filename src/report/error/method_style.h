/// Colours and marks of methods. They are the same in every chart; methods of one kind share a hue and a mark.
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

/// Returns the style of a method. It depends only on the name and the kind of the method.
MethodStyle style_of(const IntegratorInfo& method);

/// Colour and mark of one kind of method.
struct FamilyStyle {
    MethodFamily family;
    const char* name;
    int hue, saturation;  ///< Degrees and per cent, as in CSS hsl().
    Mark mark;
    /// Returns a CSS colour. Shifts of hue and lightness distinguish methods of the same kind.
    std::string color(int hue_shift = 0, int lightness = 42) const;
};
/// Returns the styles of all kinds of methods, in the order of the legend.
const std::vector<FamilyStyle>& family_styles();

}  // namespace kagero
