#include "study/kept_points.h"

#include "plan/names.h"
#include "plan/variant.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <sstream>
#include <type_traits>

namespace kagero {
namespace {

/// What is stored of a point. Times are NaN if there are none.
struct StoredPoint {
    StudyPoint point;
    double estimate, with_surfaces, without_surfaces;
    std::uint64_t max_steps;
};
static_assert(std::is_trivially_copyable_v<StoredPoint> && sizeof(StoredPoint) % sizeof(std::uint64_t) == 0);
using StoredNumbers = std::array<std::uint64_t, sizeof(StoredPoint) / sizeof(std::uint64_t)>;

double first_or_nan(const std::vector<double>& times) {
    return times.empty() ? std::numeric_limits<double>::quiet_NaN() : times.front();
}

/// Returns the name of the point of a variant: method, strategy, precision, step and solver tolerance.
std::string name_of_point(const Plan& plan, const Variant& variant) {
    std::ostringstream name;
    name << info_of(plan, variant).name << ' ' << name_of(variant.kernel->strategy) << ' '
         << name_of(variant.kernel->precision) << ' ' << std::hexfloat << variant.step << ' '
         << variant.solver_tolerance;
    return name.str();
}

}  // namespace

void keep_point(const PointStore& store, const Plan& plan, const StudyPoint& point, const TimedPoint& timed) {
    if (!store.keep) return;
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    const StoredPoint stored{point, timed.estimate, store.has_times ? first_or_nan(timed.with_surfaces) : none,
                             store.has_times ? first_or_nan(timed.without_surfaces) : none, timed.max_steps};
    const auto numbers = std::bit_cast<StoredNumbers>(stored);
    store.keep(name_of_point(plan, timed.variant), {numbers.begin(), numbers.end()});
}

std::optional<StudyPoint> restore_point(const PointStore& store, const Plan& plan, TimedPoint& timed) {
    const auto content = store.find ? store.find(name_of_point(plan, timed.variant)) : std::optional<PointContent>();
    StoredNumbers numbers;
    if (!content || content->size() != numbers.size()) return {};
    std::copy(content->begin(), content->end(), numbers.begin());
    const auto stored = std::bit_cast<StoredPoint>(numbers);
    timed.estimate = stored.estimate;
    timed.max_steps = static_cast<std::uint32_t>(stored.max_steps);
    if (!store.has_times) return stored.point;
    if (stored.with_surfaces >= 0) timed.with_surfaces = {stored.with_surfaces};
    if (stored.without_surfaces >= 0) timed.without_surfaces = {stored.without_surfaces};
    return stored.point;
}

}  // namespace kagero
