#include "adaptive/bundle.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace kagero {
namespace {

/// Evaluates positions on a path at increasing fractions of its length. Between two points of the path, the curve is
/// the cubic Hermite curve with their directions.
class PathCursor {
public:
    explicit PathCursor(std::span<const PathVertex> path) : path_(path) {}

    double length() const { return path_.back().length; }

    Double3 position(double fraction) {
        const double at = fraction * length();
        while (next_ + 1 < path_.size() && path_[next_].length < at) ++next_;
        const PathVertex &a = path_[next_ - 1], &b = path_[next_];
        const double h = b.length - a.length;
        if (!(h > 0)) return b.position;
        const double t = std::clamp((at - a.length) / h, 0.0, 1.0), s = 1 - t;
        Double3 q;
        for (std::size_t k = 0; k < 3; ++k)
            q[k] = s * s * ((1 + 2 * t) * a.position[k] + t * h * a.direction[k]) +
                   t * t * ((1 + 2 * s) * b.position[k] - s * h * b.direction[k]);
        return q;
    }

private:
    std::span<const PathVertex> path_;
    std::size_t next_ = 1;  ///< Index of the vertex at the end of the current step.
};

/// Returns a lower bound on the distance from q to all surfaces: the distance to the faces of the clear box around q.
/// The result is 0 if q is not in a clear box.
double distance_in_clear_box(const ClearanceGrid& grid, const Double3& q) {
    double x[3];
    std::size_t cell = 0;
    for (std::size_t k = 3; k-- > 0;) {
        x[k] = (q[k] - grid.origin[k]) / grid.cell[k];
        if (!(x[k] >= 0 && x[k] < grid.cells[k])) return 0;
        cell = cell * grid.cells[k] + static_cast<std::size_t>(x[k]);
    }
    const float* box = grid.boxes + static_cast<std::size_t>(grid.box_index[cell]);
    double distance = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < 3; ++k)
        distance =
            std::min({distance, (x[k] - double(box[k])) * grid.cell[k], (double(box[3 + k]) - x[k]) * grid.cell[k]});
    return std::max(distance, 0.0);
}

}  // namespace

bool keeps_clear(const Bundle& bundle, const Geometry& geometry, const std::optional<Face>& end_face) {
    constexpr double margin = 1.25;        // radius of the ball, divided by the distance to the farthest outer ray
    constexpr double bend_margin = 2;      // addition to the radius, divided by the bend of the bundle
    constexpr double advance_share = 0.8;  // because the radius can grow along the ray
    constexpr int max_positions = 256;
    if (bundle.middle.size() < 2) return false;
    PathCursor middle(bundle.middle);
    std::vector<PathCursor> outer;
    for (const auto& path : bundle.outer) {
        if (path.size() < 2) return false;
        outer.emplace_back(path);
    }
    double at = 0;
    for (int i = 0; i < max_positions; ++i) {
        const double fraction = std::min(at / middle.length(), 1.0);
        BundleSlice slice{{middle.position(fraction)}, 0};
        double widest = 0, bend = 0;  // distances of an outer ray, and of the mean of two opposite ones, to the middle
        for (std::size_t k = 0; k < 8; ++k) {
            slice.points[1 + k] = outer[k].position(fraction);
            widest = std::max(widest, length(subtract(slice.points[1 + k], slice.points[0])));
        }
        for (std::size_t k = 0; k < 4; ++k) {
            const Double3 mean = scaled(add(slice.points[1 + k], slice.points[8 - k]), 0.5);
            bend = std::max(bend, length(subtract(mean, slice.points[0])));
        }
        slice.radius = margin * widest + bend_margin * bend;
        if (fraction == 1) return true;
        double gap =
            geometry.clearance ? distance_in_clear_box(*geometry.clearance, slice.points[0]) - slice.radius : 0;
        if (gap <= slice.radius)
            gap = gap_to_surfaces(geometry, slice, std::max(8 * slice.radius, 0.05 * middle.length()), end_face);
        if (!(gap > 0)) return false;
        at += advance_share * gap;
    }
    return false;
}

}  // namespace kagero
