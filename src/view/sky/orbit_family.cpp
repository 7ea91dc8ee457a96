#include "view/sky/orbit_family.h"

#include "plan/view.h"
#include "scene/vector3.h"

#include <algorithm>

namespace kagero {
namespace {

constexpr float infinite = std::numeric_limits<float>::infinity();
constexpr std::uint32_t most_cells = 1 << 12;  ///< Greatest number of cells in an interval.

/// Returns the components of the unit vector at τ along the radial direction and perpendicular to it. The sum of their
/// magnitudes is 1 instead of the sum of their squares.
std::array<double, 2> components_at(double tau) { return {1 - tau, 1 - std::abs(1 - tau)}; }

/// Returns the length of the second difference at `i`. Returns infinity if the three rays do not reach the same sky.
float second_difference(const std::vector<PlanarEnd>& ends, std::size_t i) {
    const PlanarEnd &a = ends[i - 1], &b = ends[i], &c = ends[i + 1];
    if (a.kind != b.kind || c.kind != b.kind || !SkyEnd{{}, b.kind}.reaches_sky()) return infinite;
    return std::hypot(a.radial - 2 * b.radial + c.radial, a.transverse - 2 * b.transverse + c.transverse);
}

float error_of_cell(const std::vector<PlanarEnd>& ends, std::size_t cell) {
    if (ends[cell].kind != ends[cell + 1].kind) return infinite;
    if (ends[cell].kind == SkyEnd::Kind::captured) return 0;
    const std::size_t last = ends.size() - 2;
    return std::max(second_difference(ends, std::clamp<std::size_t>(cell, 1, last)),
                    second_difference(ends, std::clamp<std::size_t>(cell + 1, 1, last))) /
           8;
}

/// Returns the angle on the sky per angle of view in a cell between two values of τ: along the radius, and around it.
float magnification_of_cell(const PlanarEnd& a, const PlanarEnd& b, double first_tau, double last_tau) {
    const auto [radial, transverse] = components_at(0.5 * (first_tau + last_tau));
    const double square = radial * radial + transverse * transverse, angle = (last_tau - first_tau) / square;
    const float along = std::hypot(b.radial - a.radial, b.transverse - a.transverse) / float(angle),
                around = 0.5f * std::abs(a.transverse + b.transverse) * float(std::sqrt(square) / transverse);
    return mean_magnification(along, around);
}

Double3 position_of_camera(const Plan& plan) {
    const double* q = plan.view.camera.position;
    return {q[0], q[1], q[2]};
}

/// Divides every cell into two, or an interval without ends into `first_cells` cells. Ends that the interval has
/// already are kept; the indices of the others, which must be traced, are added to `missing`.
void divide(OrbitInterval& interval, std::uint32_t first_cells, std::vector<std::size_t>& missing) {
    const std::size_t before = interval.cells.size(), cells = before == 0 ? first_cells : 2 * before;
    std::vector<PlanarEnd> ends(cells + 1);
    for (std::size_t i = 0; i <= cells; ++i) {
        if (before != 0 && i % 2 == 0) ends[i] = interval.ends[i / 2];
        else missing.push_back(i);
    }
    interval.ends = std::move(ends);
    interval.cells.resize(cells);
}

}  // namespace

bool OrbitFamily::contains_rays_of(const Plan& plan) { return why_no_orbit_family(*plan.scene, plan.view).empty(); }

OrbitFamily::OrbitFamily(const Plan& plan) : intervals_(interval_count) {
    const Double3 radial = unit(position_of_camera(plan));
    const Double3 other = std::abs(radial[0]) < 0.5 ? Double3{1, 0, 0} : Double3{0, 1, 0};
    const Double3 across = unit(cross(radial, other));
    axes_ = {radial, across, cross(radial, across)};
    for (std::size_t b = 0; b < 3; ++b) std::copy(axes_[b].begin(), axes_[b].end(), float_axes_[b].begin());
}

void OrbitFamily::trace(const Plan& plan, const std::vector<std::uint32_t>& intervals, std::uint32_t first_cells) {
    constexpr double width = 2.0 / interval_count;
    std::vector<std::vector<std::size_t>> missing(intervals.size());
    std::vector<Double3> directions;
    for (std::size_t i = 0; i < intervals.size(); ++i) {
        OrbitInterval& interval = intervals_[intervals[i]];
        divide(interval, first_cells, missing[i]);
        for (const std::size_t end : missing[i]) {
            const double share = double(end) / double(interval.cells.size());
            const auto [radial, transverse] = components_at((intervals[i] + share) * width);
            directions.push_back(add(scaled(axes_[0], radial), scaled(axes_[1], transverse)));
        }
    }
    const std::vector<SkyEnd> ends = trace_sky_ends(plan, directions, rays_, seconds_);
    auto next = ends.begin();
    for (std::size_t i = 0; i < intervals.size(); ++i) {
        OrbitInterval& interval = intervals_[intervals[i]];
        for (const std::size_t end : missing[i]) {
            const Double3 direction{next->direction[0], next->direction[1], next->direction[2]};
            interval.ends[end] = {float(dot(direction, axes_[0])), float(dot(direction, axes_[1])), next->kind};
            ++next;
        }
        const std::size_t cells = interval.cells.size();
        for (std::size_t cell = 0; cell < cells; ++cell) {
            const double first = (intervals[i] + double(cell) / double(cells)) * width;
            const PlanarEnd &a = interval.ends[cell], &b = interval.ends[cell + 1];
            interval.cells[cell] = {a.radial,
                                    a.transverse,
                                    b.radial - a.radial,
                                    b.transverse - a.transverse,
                                    error_of_cell(interval.ends, cell),
                                    magnification_of_cell(a, b, first, first + width / double(cells)),
                                    a.kind};
        }
    }
}

void OrbitFamily::refine(const Plan& plan, double max_error, double first_width, double least_width) {
    // |dτ/dα| is between 1/2 and 1.
    constexpr double width = 4.0 / interval_count;
    std::uint32_t first_cells = 2;
    while (first_cells < most_cells && width / first_cells > first_width) first_cells *= 2;
    for (;;) {
        std::vector<std::uint32_t> coarse;
        for (std::uint32_t i = 0; i < interval_count; ++i) {
            const auto& cells = intervals_[i].cells;
            const bool can_refine = cells.size() < most_cells && width / double(cells.size()) > least_width;
            const auto is_coarse = [&](const OrbitCell& cell) { return cell.error > max_error; };
            if (cells.empty() || (can_refine && std::any_of(cells.begin(), cells.end(), is_coarse)))
                coarse.push_back(i);
        }
        if (coarse.empty()) return;
        trace(plan, coarse, first_cells);
    }
}

void OrbitFamily::set_row(Row& row, const Double3& first, const Double3& step, std::uint32_t count) const {
    for (auto* numbers : {&row.tau, &row.across, &row.upward, &row.inverse_length}) numbers->resize(count);
    float begin[3], by[3];  // along the axes
    for (std::size_t k = 0; k < 3; ++k) {
        begin[k] = float(dot(first, axes_[k]));
        by[k] = float(dot(step, axes_[k]));
    }
    for (std::uint32_t i = 0; i < count; ++i) {
        const auto n = float(std::int32_t(i));
        const float radial = begin[0] + n * by[0], across = begin[1] + n * by[1], upward = begin[2] + n * by[2],
                    square = across * across + upward * upward, transverse = std::max(std::sqrt(square), 1e-30f),
                    inverse = 1 / transverse;
        row.tau[i] = 1 - radial / (std::abs(radial) + transverse);
        row.across[i] = across * inverse;
        row.upward[i] = upward * inverse;
        row.inverse_length[i] = 1 / std::sqrt(square + radial * radial);
    }
}

}  // namespace kagero
