#include "geometry/files/polygons.h"

#include <algorithm>

namespace kagero {

namespace {

struct Point2 {
    double x = 0, y = 0;
    bool operator==(const Point2&) const = default;
};

/// Returns twice the area of a triangle, which is positive if its corners are in counterclockwise order.
double doubled_area(const Point2& a, const Point2& b, const Point2& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// An upper bound on the rounding errors of areas, for polygons whose size is about 1.
constexpr double area_error = 1e-12;

/// Returns true if two edges of a polygon cross at a point that is an end of neither.
bool has_crossing_edges(const std::vector<Point2>& points) {
    const auto opposite = [](double a, double b) {
        return std::min(a, b) < -area_error && std::max(a, b) > area_error;
    };
    const std::size_t n = points.size();
    for (std::size_t i = 0; i + 2 < n; ++i) {
        const Point2 &a = points[i], &b = points[i + 1];
        double left = doubled_area(a, b, points[i + 2]);
        for (std::size_t j = i + 2; j < n; ++j) {
            const Point2 &c = points[j], &d = points[j + 1 == n ? 0 : j + 1];
            const double next = doubled_area(a, b, d);
            if (opposite(left, next) && opposite(doubled_area(c, d, a), doubled_area(c, d, b))) return true;
            left = next;
        }
    }
    return false;
}

/// Returns the corners of a polygon, projected along the coordinate axis that is nearest to its normal. The polygon is
/// counterclockwise in the projection, and its size is about 1. The result is empty if the polygon has no normal.
std::vector<Point2> projection(const FileMesh& mesh, const std::uint32_t* corners, std::size_t count) {
    const auto point = [&](std::size_t i) {
        const double* v = &mesh.vertices[3 * std::size_t{corners[i]}];
        return Double3{v[0], v[1], v[2]};
    };
    const Double3 origin = point(0);
    double size = 0;
    for (std::size_t i = 0; i < count; ++i)
        for (const double offset : subtract(point(i), origin)) size = std::max(size, std::abs(offset));
    if (!(size > 0) || !std::isfinite(size)) return {};
    // The sum of these cross products is twice the vector area of the polygon, also if the polygon is concave.
    Double3 normal{};
    for (std::size_t i = 1; i + 1 < count; ++i)
        normal = add(normal, cross(scaled(subtract(point(i), origin), 1 / size),
                                   scaled(subtract(point(i + 1), origin), 1 / size)));
    std::size_t axis = 0;
    for (std::size_t k = 1; k < 3; ++k)
        if (std::abs(normal[k]) > std::abs(normal[axis])) axis = k;
    if (!(std::abs(normal[axis]) > area_error)) return {};
    std::vector<Point2> points(count);
    const std::size_t right = (axis + 1) % 3, up = (axis + 2) % 3;
    for (std::size_t i = 0; i < count; ++i) {
        const Double3 offset = subtract(point(i), origin);
        points[i] = normal[axis] > 0 ? Point2{offset[right] / size, offset[up] / size}
                                     : Point2{offset[up] / size, offset[right] / size};
    }
    return points;
}

/// Returns true if all corners of a polygon are on one line. A polygon without a normal that is no line crosses itself.
bool is_line(const FileMesh& mesh, const std::uint32_t* corners, std::size_t count) {
    Double3 farthest{};
    std::vector<Double3> offsets;
    for (std::size_t i = 0; i < count; ++i) {
        const double *v = &mesh.vertices[3 * std::size_t{corners[i]}], *o = &mesh.vertices[3 * std::size_t{corners[0]}];
        offsets.push_back({v[0] - o[0], v[1] - o[1], v[2] - o[2]});
        if (length(offsets.back()) > length(farthest)) farthest = offsets.back();
    }
    const double size = length(farthest);
    return std::none_of(offsets.begin(), offsets.end(), [&](const Double3& offset) {
        return length(cross(scaled(farthest, 1 / size), scaled(offset, 1 / size))) > area_error;
    });
}

/// Divides a polygon by ear clipping: it repeatedly removes a corner whose triangle with both neighbours contains no
/// other corner. A corner on an edge (with an angle of 180°) is not removed as a triangle without area, if possible,
/// because the neighbouring faces can have a vertex there.
class EarClipper {
public:
    explicit EarClipper(std::vector<Point2> points)
        : points_(std::move(points)), remaining_(points_.size()), previous_(remaining_), next_(remaining_),
          ear_(remaining_) {
        for (std::size_t i = 0; i < remaining_; ++i) {
            previous_[i] = i == 0 ? remaining_ - 1 : i - 1;
            next_[i] = i + 1 == remaining_ ? 0 : i + 1;
        }
        for (std::size_t i = 0; i < remaining_; ++i)
            if (!is_convex(i)) blocking_.push_back(i);
        update_all_ears();
    }

    /// Calls `emit(a, b, c)` for each triangle. Returns false if corners that are no ears had to be removed.
    template <class Emit>
    bool clip(const Emit& emit) {
        bool has_ears = true;
        std::size_t corner = 1, tried = 0, updates = 16;
        while (remaining_ > 3) {
            if (!ear_[corner] && tried < remaining_) {
                corner = next_[corner];
                ++tried;
                continue;
            }
            if (!ear_[corner] && updates > 0) {
                --updates;  // an ear may have been blocked by a corner that has been removed
                tried = 0;
                update_all_ears();
                if (std::find(ear_.begin(), ear_.end(), true) != ear_.end()) continue;
            }
            if (!ear_[corner] && std::abs(area(corner)) > area_error) has_ears = false;
            tried = 0;
            emit(previous_[corner], corner, next_[corner]);
            corner = remove(corner);
        }
        emit(previous_[corner], corner, next_[corner]);
        return has_ears;
    }

private:
    double area(std::size_t i) const { return doubled_area(points_[previous_[i]], points_[i], points_[next_[i]]); }
    bool is_convex(std::size_t i) const { return area(i) > 0; }

    /// Returns true if the corner's triangle has an area and contains no other corner, not even on its edges. It
    /// suffices to check corners that are not convex. Corners at the same position as one of the triangle's do not
    /// count: an edge that leads to a hole and back has two corners there.
    bool is_ear(std::size_t i) const {
        if (!is_convex(i)) return false;
        const Point2 &a = points_[previous_[i]], &b = points_[i], &c = points_[next_[i]];
        return std::none_of(blocking_.begin(), blocking_.end(), [&](std::size_t other) {
            const Point2& p = points_[other];
            return p != a && p != b && p != c && doubled_area(a, b, p) >= 0 && doubled_area(b, c, p) >= 0 &&
                   doubled_area(c, a, p) >= 0;
        });
    }

    void update_all_ears() {
        std::fill(ear_.begin(), ear_.end(), false);
        std::size_t i = first_;
        for (std::size_t n = 0; n < remaining_; ++n) {
            ear_[i] = is_ear(i);
            i = next_[i];
        }
    }

    /// Removes a corner, and returns the corner to continue with. It is not the next one: triangles around a single
    /// corner would be long and narrow.
    std::size_t remove(std::size_t i) {
        const std::size_t before = previous_[i], after = next_[i];
        next_[before] = after;
        previous_[after] = before;
        ear_[i] = false;
        first_ = before;
        --remaining_;
        std::erase_if(blocking_, [&](std::size_t other) {
            return other == i || ((other == before || other == after) && is_convex(other));
        });
        for (const std::size_t neighbour : {before, after}) {
            const bool listed = std::find(blocking_.begin(), blocking_.end(), neighbour) != blocking_.end();
            if (!listed && !is_convex(neighbour)) blocking_.push_back(neighbour);
        }
        for (const std::size_t neighbour : {before, after}) ear_[neighbour] = is_ear(neighbour);
        return next_[after];
    }

    std::vector<Point2> points_;
    std::size_t remaining_, first_ = 0;
    std::vector<std::size_t> previous_, next_;
    std::vector<bool> ear_;
    std::vector<std::size_t> blocking_;  ///< Remaining corners that are not convex.
};

}  // namespace

void append_polygons(FileMesh& mesh, const Polygons& polygons) {
    std::size_t first = 0, crossing = 0;
    for (const std::size_t count : polygons.sizes) {
        const std::uint32_t* corners = polygons.corners.data() + first;
        first += count;
        const auto emit = [&](std::size_t a, std::size_t b, std::size_t c) {
            mesh.triangles.insert(mesh.triangles.end(), {corners[a], corners[b], corners[c]});
        };
        if (count < 3) {
            ++mesh.points_and_lines;
        } else if (count == 3) {
            emit(0, 1, 2);
        } else if (std::vector<Point2> points = projection(mesh, corners, count); !points.empty()) {
            const bool crosses = has_crossing_edges(points);
            if (!EarClipper(std::move(points)).clip(emit) || crosses) ++crossing;
        } else {
            for (std::size_t i = 2; i < count; ++i) emit(0, i - 1, i);
            if (!is_line(mesh, corners, count)) ++crossing;
        }
    }
    if (crossing > 0)
        mesh.remarks.push_back(std::to_string(crossing) +
                               " faces have edges that cross; their triangles may not cover them");
}

void append_strip(FileMesh& mesh, const std::uint32_t* corners, std::size_t count) {
    for (std::size_t i = 2; i < count; ++i) {
        const std::uint32_t a = corners[i - 2 + i % 2], b = corners[i - 1 - i % 2], c = corners[i];
        if (a != b && b != c && c != a) mesh.triangles.insert(mesh.triangles.end(), {a, b, c});
    }
}

}  // namespace kagero
