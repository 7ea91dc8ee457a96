#include "report/method_style.h"

namespace kagero {
namespace {

struct Family {
    const char* prefix;  ///< of its methods' names; the first that fits counts
    int hue, saturation;
    Mark mark;
};
constexpr Family families[] = {
    {"satoh", 354, 72, Mark::cross},  {"euler", 354, 72, Mark::cross},  {"ks-", 282, 45, Mark::diamond},
    {"srkn", 180, 70, Mark::diamond}, {"orbit-", 180, 70, Mark::diamond}, {"gauss", 132, 55, Mark::circle}, {"midpoint", 132, 55, Mark::circle},
    {"rk", 215, 78, Mark::square},    {"dp", 215, 78, Mark::square},      {"verner", 215, 78, Mark::square}, {"", 34, 88, Mark::triangle},
};

/// Shades tell siblings apart; a name has the same one in every run.
struct Shade {
    int hue, lightness;
};
Shade shade_of(const std::string& method) {
    unsigned sum = 0;
    for (const char c : method) sum = 31 * sum + static_cast<unsigned char>(c);
    return {static_cast<int>(sum / 3 % 3) * 12 - 12, 34 + static_cast<int>(sum % 3) * 8};
}

}  // namespace

MethodStyle style_of(const std::string& method) {
    const Shade shade = shade_of(method);
    for (const Family& family : families)
        if (method.starts_with(family.prefix))
            return {"hsl(" + std::to_string(family.hue + shade.hue) + " " + std::to_string(family.saturation) + "% calc(" +
                        std::to_string(shade.lightness) + "% + var(--shade)))",
                    family.mark};
    return {"var(--ink)", Mark::circle};
}

bool same_family(const std::string& a, const std::string& b) {
    const auto hue = [](const std::string& method) {
        for (const Family& family : families)
            if (method.starts_with(family.prefix)) return family.hue;
        return 0;
    };
    return hue(a) == hue(b);
}

const std::vector<MethodFamily>& method_families() {
    static const std::vector<MethodFamily> all{{"the recipe as printed", "satoh2"},
                                               {"symmetric compositions", "verlet"},
                                               {"exact split", "ks-verlet"},
                                               {"Runge–Kutta–Nyström", "srkn6"},
                                               {"Runge–Kutta", "rk4"},
                                               {"Gauss–Legendre", "gauss8"}};
    return all;
}

}  // namespace kagero
