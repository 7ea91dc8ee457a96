#include "adaptive/bundle.h"

#include "geometry/clearance/bundle_part.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// Returns the position on a path at a fraction of its length. Between two points of the path, the curve is the cubic
/// Hermite curve with their directions.
Double3 position_on(std::span<const PathVertex> path, double fraction) {
    const double at = fraction * path.back().length;
    const auto next = std::lower_bound(path.begin() + 1, path.end() - 1, at,
                                       [](const PathVertex& vertex, double length) { return vertex.length < length; });
    const PathVertex &a = *(next - 1), &b = *next;
    const double h = b.length - a.length;
    if (!(h > 0)) return b.position;
    const double t = std::clamp((at - a.length) / h, 0.0, 1.0), s = 1 - t;
    const double of_a = s * s * (1 + 2 * t), of_b = t * t * (1 + 2 * s);
    const double along_a = s * s * t * h, along_b = t * t * s * h;
    Double3 q;
    for (std::size_t k = 0; k < 3; ++k)
        q[k] = of_a * a.position[k] + along_a * a.direction[k] + of_b * b.position[k] - along_b * b.direction[k];
    return q;
}

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

/// Points of a bundle at one fraction of the lengths of its paths.
struct Slice {
    double fraction;
    BundleSlice points;
};

Slice slice_at(const Bundle& bundle, double fraction) {
    Slice slice{fraction, {position_on(bundle.middle, fraction)}};
    for (std::size_t k = 0; k < 8; ++k) slice.points[1 + k] = position_on(bundle.outer[k], fraction);
    return slice;
}

/// The greatest lengths of vectors, and of their components across a direction and along it.
struct Extent {
    double radius = 0, across = 0, along = 0;

    void add(const Double3& offset, const Double3& direction, double factor) {
        const double projection = dot(offset, direction);
        radius = std::max(radius, factor * length(offset));
        across = std::max(across, factor * length(subtract(offset, scaled(direction, projection))));
        along = std::max(along, factor * std::abs(projection));
    }
};

/// Returns the extent of the rays of a slice around the middle ray, which moves in the given direction. If rays end on
/// a surface at a grazing angle, their lengths differ, and the slice is long along the rays. The rays between those of
/// the slice then still lie in a narrow tube.
Extent extent_of(const Slice& slice, const Double3& direction) {
    constexpr double margin = 1.25;    // extent, divided by that of the farthest outer ray
    constexpr double bend_margin = 2;  // addition to the extent, divided by the bend of the bundle
    Extent outer, bend;
    for (std::size_t k = 1; k < 9; ++k) outer.add(subtract(slice.points[k], slice.points[0]), direction, margin);
    for (std::size_t k = 0; k < 4; ++k) {
        const Double3 mean = scaled(add(slice.points[1 + k], slice.points[8 - k]), 0.5);
        bend.add(subtract(mean, slice.points[0]), direction, bend_margin);
    }
    return {outer.radius + bend.radius, outer.across + bend.across, outer.along + bend.along};
}

/// Returns the distance of point b of a curve from the middle of the chord from a to c.
double sagitta(const Double3& a, const Double3& b, const Double3& c) {
    return length(subtract(scaled(add(a, c), 0.5), b));
}

/// The test of one bundle, part by part.
class ClearanceTest {
public:
    ClearanceTest(const Bundle& bundle, const Geometry& geometry, const std::optional<Face>& end_face)
        : bundle_(bundle), geometry_(geometry), end_face_(end_face) {}

    /// Returns true if the part between two slices is clear of surfaces. Otherwise, divides the part.
    bool is_clear(const Slice& begin, const Slice& end) {
        constexpr int max_parts = 256;
        constexpr double least_length = 0.125;  // of a part, divided by its radius
        if (++parts_ > max_parts) return false;
        const Slice middle = slice_at(bundle_, 0.5 * (begin.fraction + end.fraction));
        const BundlePart part = part_of(begin, middle, end);
        if (is_in_clear_box(part) || kagero::is_clear(geometry_, part, end_face_)) return true;
        const double part_length = (end.fraction - begin.fraction) * bundle_.middle.back().length;
        if (!(part_length > least_length * part.across)) return false;
        return is_clear(begin, middle) && is_clear(middle, end);
    }

private:
    BundlePart part_of(const Slice& begin, const Slice& middle, const Slice& end) const {
        const Double3 chord = subtract(end.points[0], begin.points[0]);
        const double chord_length = length(chord);
        const Double3 direction = chord_length > 0 ? scaled(chord, 1 / chord_length) : Double3{};
        BundlePart part{{begin.points, middle.points, end.points}, 0, 0, 0, bend(begin, middle, end)};
        for (const Slice* slice : {&begin, &middle, &end}) {
            const Extent extent = extent_of(*slice, direction);
            part.radius = std::max(part.radius, extent.radius);
            part.across = std::max(part.across, extent.across);
            part.along = std::max(part.along, extent.along);
        }
        return part;
    }
    /// Returns a bound on the distance of the rays from the chords between adjacent slices: half of the greatest
    /// sagitta. For an arc that curves evenly, this distance is a quarter of the sagitta.
    double bend(const Slice& begin, const Slice& middle, const Slice& end) const {
        double greatest = 0;
        for (std::size_t k = 0; k < 9; ++k)
            greatest = std::max(greatest, sagitta(begin.points[k], middle.points[k], end.points[k]));
        return std::max({0.5 * greatest, bend_between(begin, middle), bend_between(middle, end)});
    }
    /// Returns the greatest distance of the vertices of the middle ray between two slices from the chord, with a margin
    /// for the other rays.
    double bend_between(const Slice& begin, const Slice& end) const {
        constexpr double margin = 1.25;
        const auto path = bundle_.middle;
        const double first = begin.fraction * path.back().length, last = end.fraction * path.back().length;
        const Double3 along = subtract(end.points[0], begin.points[0]);
        const double square = dot(along, along);
        double greatest = 0;
        for (auto vertex = std::upper_bound(path.begin(), path.end(), first,
                                            [](double at, const PathVertex&v) { return at < v.length; });
             vertex != path.end() && vertex->length < last; ++vertex) {
            const Double3 from = subtract(vertex->position, begin.points[0]);
            const double t = square > 0 ? dot(from, along) / square : 0;
            greatest = std::max(greatest, length(subtract(from, scaled(along, t))));
        }
        return margin * greatest;
    }
    bool is_in_clear_box(const BundlePart& part) const {
        if (!geometry_.clearance) return false;
        const Double3& middle = part.slices[1][0];
        const double half =
            std::max(length(subtract(part.slices[0][0], middle)), length(subtract(part.slices[2][0], middle)));
        return distance_in_clear_box(*geometry_.clearance, middle) > half + part.radius + part.bend;
    }

    const Bundle& bundle_;
    const Geometry& geometry_;
    const std::optional<Face>& end_face_;
    int parts_ = 0;
};

}  // namespace

bool keeps_clear(const Bundle& bundle, const Geometry& geometry, const std::optional<Face>& end_face) {
    if (bundle.middle.size() < 2) return false;
    for (const auto& path : bundle.outer)
        if (path.size() < 2) return false;
    return ClearanceTest(bundle, geometry, end_face).is_clear(slice_at(bundle, 0), slice_at(bundle, 1));
}

}  // namespace kagero
