#include "report/method_style.h"

namespace kagero {
namespace {

struct Family {
    const char* prefix;  ///< of its methods' names; the first that fits counts
    int hue, saturation;
    Mark mark;
};
constexpr Family families[] = {
    {"satoh", 2, 72, Mark::cross},    {"euler", 2, 72, Mark::cross},    {"ks-", 282, 45, Mark::diamond},
    {"srkn", 185, 70, Mark::diamond}, {"gauss", 140, 55, Mark::circle}, {"midpoint", 140, 55, Mark::circle},
    {"rk", 214, 78, Mark::square},    {"dp", 214, 78, Mark::square},    {"", 32, 85, Mark::triangle},
};

/// The same for a name in every run: lighter and darker shades tell siblings apart.
int lightness_of(const std::string& method) {
    unsigned sum = 0;
    for (const char c : method) sum = 31 * sum + static_cast<unsigned char>(c);
    return 36 + static_cast<int>(sum % 5) * 4;
}

}  // namespace

MethodStyle style_of(const std::string& method) {
    for (const Family& family : families)
        if (method.starts_with(family.prefix))
            return {"hsl(" + std::to_string(family.hue) + " " + std::to_string(family.saturation) + "% calc(" +
                        std::to_string(lightness_of(method)) + "% + var(--shade)))",
                    family.mark};
    return {"var(--ink)", Mark::circle};
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
