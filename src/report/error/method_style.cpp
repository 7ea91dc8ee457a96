#include "report/error/method_style.h"

#include <algorithm>
#include <string_view>

namespace kagero {

const std::vector<FamilyStyle>& family_styles() {
    static const std::vector<FamilyStyle> all{
        {MethodFamily::recipe, "recipe as printed (Satoh 2003)", 354, 72, Mark::cross},
        {MethodFamily::composition, "compositions", 34, 88, Mark::triangle},
        {MethodFamily::exact_split, "exact split", 282, 45, Mark::diamond},
        {MethodFamily::nystroem, "Runge–Kutta–Nyström", 180, 70, Mark::diamond},
        {MethodFamily::runge_kutta, "Runge–Kutta", 215, 78, Mark::square},
        {MethodFamily::gauss, "Gauss–Legendre", 132, 55, Mark::circle},
    };
    return all;
}

std::string FamilyStyle::color(int hue_shift, int lightness) const {
    return "hsl(" + std::to_string(hue + hue_shift) + " " + std::to_string(saturation) + "% calc(" +
           std::to_string(lightness) + "% + var(--shade)))";
}

MethodStyle style_of(const IntegratorInfo& method) {
    const auto& families = family_styles();
    const auto family =
        std::find_if(families.begin(), families.end(), [&](const FamilyStyle& f) { return f.family == method.family; });
    if (family == families.end()) return {"var(--ink)", Mark::circle};
    // The colour depends on a hash of the name, so that a method has the same colour in every report.
    unsigned hash = 0;
    for (const char c : std::string_view(method.name)) hash = 31 * hash + static_cast<unsigned char>(c);
    const int hue_shift = static_cast<int>(hash / 3 % 3) * 12 - 12, lightness = 34 + static_cast<int>(hash % 3) * 8;
    return {family->color(hue_shift, lightness), family->mark};
}

}  // namespace kagero
