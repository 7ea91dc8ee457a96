#include "render/spread.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kagero {

Spread spread_of(std::vector<double> values) {
    constexpr double not_known = std::numeric_limits<double>::quiet_NaN();
    if (values.empty()) return {not_known, not_known, not_known, not_known};
    auto rest = values.begin();  // where none is less than those before
    const auto at = [&](double share) {
        const auto place = values.begin() + static_cast<std::ptrdiff_t>(std::ceil(share * static_cast<double>(values.size()))) - 1;
        std::nth_element(rest, place, values.end());
        return *(rest = place);
    };
    return {at(0.5), at(0.9), at(0.99), at(1.0)};
}

}  // namespace kagero
