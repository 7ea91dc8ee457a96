/// Rays that start on a surface which their RayStart names, such as reflected rays. The position of such a start is
/// rounded, so it may lie slightly in front of or behind the surface. The name and the direction decide on which side
/// of the surfaces close by the ray starts.
///
/// The ray starts on the triangle or sphere T and leaves it to the side to which its velocity points.
/// - T itself is hit only where the ray returns to it. The first piece of a path ends where its distance from T begins
///   to decrease (`end_of_departure`). T is tested in the piece that follows, without Embree.
/// - Another triangle N is not hit on the first piece if no corner of N lies on that side of T. Otherwise, the ray
///   starts on the side of N on which T lies, and it hits N if it ends the piece on the other side. If N divides T, the
///   height of the start decides; within rounding of N, the ray counts as hitting N. If N and T have a common corner
///   close to the start, the centre of T decides instead.
/// - A sphere close by is hit unless the ray moves away from it.
#pragma once

#include "kernels/assertion.h"
#include "kernels/integrators/curve.h"
#include "kernels/intersection/segment_query.h"
#include "kernels/intersection/triangle.h"

#include <algorithm>
#include <cmath>

namespace kagero {

/// Returns lane i of a vector, in double precision.
template <class V>
Vec3<double> lane_of(const Vec3<V>& v, int i) {
    return {double(get_lane(v.x, i)), double(get_lane(v.y, i)), double(get_lane(v.z, i))};
}

/// The named surfaces on which the rays of a packet start.
template <class V>
class SurfaceStarts {
    using S = ScalarOf<V>;
    static constexpr int W = lane_count<V>;

public:
    explicit SurfaceStarts(const Geometry& geometry) : geometry_(geometry) {}

    /// Stores the named surfaces of the new rays `named`, which are some of `lanes`.
    void begin(std::uint64_t lanes, std::uint64_t named, const std::uint32_t* surface, const std::uint32_t* primitive) {
        forget(lanes);
        named_ |= lanes & named;
        for (const int i : lanes_in(lanes & named)) {
            KAGERO_ASSERT(surface[i] < geometry_.surface_count);
            surface_[i] = surface[i];
            const bool is_sphere = geometry_.surfaces[surface[i]].kind == Surface::Kind::sphere;
            primitive_[i] = is_sphere ? 0 : primitive[i];
            if (!is_sphere) on_triangles_ |= std::uint64_t(1) << i;
        }
        restart(lanes);
    }
    /// The next step of those of `lanes` that have a named surface begins at the start of their ray.
    void restart(std::uint64_t lanes) {
        departing_ |= lanes & named_;
        returning_ &= ~lanes;
    }
    /// Forgets the named surfaces of `lanes`.
    void forget(std::uint64_t lanes) {
        named_ &= ~lanes;
        on_triangles_ &= ~lanes;
        leave(lanes);
    }
    /// The next segments of `lanes` do not begin close to the named surface.
    void leave(std::uint64_t lanes) {
        departing_ &= ~lanes;
        returning_ &= ~lanes;
    }

    /// Called after segments of `lanes`: those of departing rays have left the named surface.
    void end_segments(std::uint64_t lanes) {
        returning_ &= ~(lanes & ~departing_);
        departing_ &= ~lanes;
    }

    std::uint64_t named() const { return named_; }          ///< Lanes whose rays have a named surface.
    std::uint64_t departing() const { return departing_; }  ///< Lanes whose next segment begins on the named surface.
    std::uint64_t returning() const { return returning_; }  ///< Lanes whose next segment begins to return to it.
    /// Returns those of `lanes` whose next segment begins on a named triangle, with these triangles.
    IgnoredTriangles departing_from_triangles(std::uint64_t lanes) const {
        return {lanes & departing_ & on_triangles_, surface_, primitive_};
    }
    std::uint32_t surface(int lane) const { return surface_[lane]; }
    std::uint32_t primitive(int lane) const { return primitive_[lane]; }
    /// Returns those of `lanes` whose `surface` is the named sphere and whose ray has left it to the inside.
    std::uint64_t inside(std::uint64_t lanes, const std::uint32_t (&surface)[W]) const {
        std::uint64_t inside = 0;
        for (const int i : lanes_in(lanes & named_))
            if (surface[i] == surface_[i] && level_set(i).curved && side_[i] < 0) inside |= std::uint64_t(1) << i;
        return inside;
    }
    /// Returns true if this triangle or sphere is the named one.
    bool is_named(int lane, std::uint32_t surface, std::uint32_t primitive) const {
        return surface == surface_[lane] && primitive == primitive_[lane];
    }
    /// Returns true if another triangle and the named one have a common corner.
    bool is_neighbor(int lane, std::uint32_t surface, std::uint32_t primitive) const {
        const Surface &named = geometry_.surfaces[surface_[lane]], &other = geometry_.surfaces[surface];
        return named.kind == Surface::Kind::triangles && other.kind == Surface::Kind::triangles &&
               triangle_of(named, primitive_[lane]).has_common_corner(triangle_of(other, primitive));
    }
    /// Returns the level set of the named surface.
    LevelSet<double> level_set(int lane) const {
        return level_set_of(geometry_.surfaces[surface_[lane]], primitive_[lane]);
    }

    /// Sets the side on which a ray that begins at `start` with the direction v leaves its named surface.
    void set_side(int lane, const Vec3<double>& start, const Vec3<double>& v) {
        side_[lane] = level_set(lane).slope(start, v) < 0 ? -1 : 1;
    }
    /// Returns the ends of the first pieces of paths in departing `lanes`, as fractions of the step: `end`, or the
    /// point where the distance from the named surface begins to decrease. In the second case, the lane then counts as
    /// returning.
    V ends_of_departure(const Curve<V>& curve, const V& end, std::uint64_t lanes) {
        const LevelSet<V> g = level_sets_of<V>(geometry_.surfaces, surface_, primitive_, lanes);
        const Vec3<V> q0 = curve.at(V(S(0))), v0 = curve.slope(V(S(0))), q1 = curve.at(end), v1 = curve.slope(end);
        const V at_start = g.slope(q0, v0), at_end = g.slope(q1, v1);
        // Close to zero, the slopes in double precision decide.
        constexpr S small = S(1e-3);
        const V limit = V(small) * fast_sqrt(min(dot(v0, v0), dot(v1, v1)));
        const std::uint64_t departs =
            lanes & to_bits((min(abs(at_start), abs(at_end)) > limit) & (at_start * at_end > V(S(0))));
        const std::uint64_t to_front = to_bits(at_start > V(S(0)));
        for (const int i : lanes_in(departs)) side_[i] = (to_front >> i) & 1 ? 1 : -1;
        V ends = end;
        for (const int i : lanes_in(lanes & ~departs))
            set_lane(ends, i, S(end_of_departure(i, curve, double(get_lane(end, i)))));
        return ends;
    }
    /// Does the same for one lane.
    double end_of_departure(int lane, const Curve<V>& curve, double end) {
        const LevelSet<double> g = level_set(lane);
        const auto slope = [&](double s) { return side_[lane] * slope_at(g, curve, lane, s); };
        set_side(lane, lane_of(curve.at(V(S(0))), lane), lane_of(curve.slope(V(S(0))), lane));
        if (!(slope(end) < 0)) return end;
        returning_ |= std::uint64_t(1) << lane;
        return extremum(slope, 0, end);
    }
    /// Returns the fraction of the step at which a path begins to approach `g` in the piece from `start` to `end`: it
    /// is `start` unless the path moves away first.
    double begin_of_approach(int lane, const LevelSet<double>& g, const Curve<V>& curve, double start,
                             double end) const {
        const double direction = g.value(lane_of(curve.at(V(S(end))), lane)) < 0 ? -1 : 1;
        const auto slope = [&](double s) { return -direction * slope_at(g, curve, lane, s); };
        return slope(start) > 0 && slope(end) < 0 ? extremum(slope, start, end) : start;
    }

    /// Returns the fraction of the segment at which a returning ray meets the plane or sphere of its named surface, or
    /// infinity. If `exact`, the ray is straight and begins on the surface.
    double return_fraction(int lane, const Vec3<double>& from, const Vec3<double>& to, bool exact) const {
        constexpr double none = std::numeric_limits<double>::infinity();
        const LevelSet<double> g = level_set(lane);
        const Vec3<double> chord = to - from, radius = from - g.center;
        if (exact) {
            const double second = -2 * dot(radius, chord) / dot(chord, chord);
            return g.curved && side_[lane] < 0 && second > 0 && second <= 1 ? second : none;
        }
        const double before = std::max(side_[lane] * g.value(from), 0.0), after = side_[lane] * g.value(to);
        if (!(after < 0)) return none;
        const double linear = before / (before - after);
        return g.curved ? std::clamp(chord_fraction(g, from, to, linear), 0.0, 1.0) : linear;
    }

    /// Returns those of `lanes` whose segment a → b, which departs from a named triangle, clearly hits the surface g at
    /// `fraction`: the start lies off that surface and the hit off the named triangle, by more than rounding, and the
    /// segment ends beyond a plane. For such hits, `can_hit` is true.
    std::uint64_t hits_clearly(std::uint64_t lanes, const LevelSet<V>& g, const Vec3<V>& a, const Vec3<V>& b,
                               const V& fraction) const {
        const LevelSet<V> named = level_sets_of<V>(geometry_.surfaces, surface_, primitive_, lanes);
        const V zero(S(0)), far = V(S(16)) * rounding_at(a), before = g.value(a), after = g.value(b);
        const MaskOf<V> ends_beyond = (abs(g.a) > zero) | ((abs(after) > far) & (before * after < zero));
        return lanes & to_bits((abs(before) > far) & (abs(named.value(advance(a, fraction, b - a))) > far) &
                               ends_beyond & (fraction > zero));
    }

    /// Returns true if the segment from → to of a departing or returning ray can hit another surface, whose level set
    /// it meets at `fraction`.
    bool can_hit(int lane, std::uint32_t surface, std::uint32_t primitive, const Vec3<double>& from,
                 const Vec3<double>& to, double fraction) const {
        const Surface& other = geometry_.surfaces[surface];
        const LevelSet<double> g = level_set_of(other, primitive);
        const double height = g.value(from), rounding = rounding_at(from), slope = g.slope(from, to - from);
        if (other.kind == Surface::Kind::sphere) {
            if (std::abs(height) > rounding) return fraction > 0;
            if (!is_inside(lane, g, rounding)) return slope < 0;
            const Vec3<double> chord = to - from;
            return fraction > -dot(from - g.center, chord) / dot(chord, chord);
        }
        const bool begins_on_named = ((departing_ >> lane) & 1) != 0;
        if (begins_on_named && !reaches_side(lane, triangle_of(other, primitive), rounding)) return false;
        double side = side_of(lane, g, slope, rounding);
        if (!begins_on_named && std::abs(height) > rounding) side = height;
        else if (side == 0) side = side_if_divided(lane, surface, primitive, g, height, slope, rounding);
        return side * g.value(to) < 0;
    }
    /// Returns the rounding error of a height above a plane at q.
    template <class T>
    T rounding_at(const Vec3<T>& q) const {
        const T size = greatest_component(q) + T(ScalarOf<T>(1 / geometry_.scale));
        return T(ScalarOf<T>(4 * machine_epsilon<S>)) * size;
    }

private:
    /// Returns the derivative of g along a path at the fraction s of the step.
    static double slope_at(const LevelSet<double>& g, const Curve<V>& curve, int lane, double s) {
        return g.slope(lane_of(curve.at(V(S(s))), lane), lane_of(curve.slope(V(S(s))), lane));
    }
    /// Returns the zero of `slope` between a, where it is positive, and b, where it is negative.
    template <class Slope>
    static double extremum(const Slope& slope, double a, double b) {
        double at_a = slope(a), at_b = slope(b);
        for (int i = 0; i < 60 && at_a > 0 && b - a > 1e-3 * b; ++i) {
            const double secant = a + (b - a) * at_a / (at_a - at_b), middle = i % 3 == 2 ? 0.5 * (a + b) : secant,
                         value = slope(middle);
            if (value == 0) return middle;
            (value > 0 ? a : b) = middle;
            (value > 0 ? at_a : at_b) = value;
        }
        return b;
    }
    /// Returns true if a corner of the triangle lies on the side of the named surface on which the ray leaves it.
    bool reaches_side(int lane, const Triangle<double>& triangle, double rounding) const {
        const LevelSet<double> named = level_set(lane);
        if (named.curved && side_[lane] < 0) return true;  // triangles outside of a ball may reach into it
        double greatest = -std::numeric_limits<double>::infinity();
        for (const Vec3<double>& corner : triangle.corner)
            greatest = std::max(greatest, side_[lane] * named.value(corner));
        return greatest > rounding;
    }
    /// Returns the side of the plane g on which the named surface lies, as a number of that sign; 0 if g divides it. If
    /// both lie in one plane, returns the side to which the ray leaves.
    double side_of(int lane, const LevelSet<double>& g, double slope, double rounding) const {
        const Surface& named = geometry_.surfaces[surface_[lane]];
        double least, greatest;
        if (named.kind == Surface::Kind::sphere) {
            const double height = g.value(level_set(lane).center);
            least = height - named.radius;
            greatest = height + named.radius;
        } else {
            const Triangle<double> triangle = triangle_of(named, primitive_[lane]);
            const double heights[3] = {g.value(triangle.corner[0]), g.value(triangle.corner[1]),
                                       g.value(triangle.corner[2])};
            least = *std::min_element(heights, heights + 3);
            greatest = *std::max_element(heights, heights + 3);
        }
        if (least >= -rounding && greatest <= rounding) {
            const double orientation = dot(level_set(lane).normal, g.normal);
            return orientation != 0 ? orientation * side_[lane] : slope;
        }
        if (least >= -rounding) return 1;
        return greatest <= rounding ? -1 : 0;
    }
    /// Returns the side of a triangle on which a ray starts if the plane g of the triangle divides the named surface.
    /// Close to a common corner of two triangles, it is the side of the centre of the named triangle.
    double side_if_divided(int lane, std::uint32_t surface, std::uint32_t primitive, const LevelSet<double>& g,
                           double height, double slope, double rounding) const {
        const Surface& named = geometry_.surfaces[surface_[lane]];
        const double close = std::max(10 * rounding, 1e-9 / geometry_.scale);
        if (named.kind == Surface::Kind::triangles && std::abs(height) <= close) {
            const Triangle<double> own = triangle_of(named, primitive_[lane]),
                                   other = triangle_of(geometry_.surfaces[surface], primitive);
            const double middle = g.value(own.center());
            if (own.has_common_corner(other) && std::abs(middle) > rounding) return middle;
        }
        return std::abs(height) > rounding ? height : -slope;
    }
    /// Returns true if the named surface lies inside of the sphere g.
    bool is_inside(int lane, const LevelSet<double>& g, double rounding) const {
        const Surface& named = geometry_.surfaces[surface_[lane]];
        if (named.kind == Surface::Kind::sphere) return g.value(level_set(lane).center) < 0;
        for (const Vec3<double>& corner : triangle_of(named, primitive_[lane]).corner)
            if (g.value(corner) > rounding) return false;
        return true;
    }

    const Geometry& geometry_;
    std::uint64_t named_ = 0, departing_ = 0, returning_ = 0;
    std::uint64_t on_triangles_ = 0;  ///< Lanes whose named surface is a triangle.
    std::uint32_t surface_[W] = {}, primitive_[W] = {};
    double side_[W] = {};  ///< 1 or −1: the sign of the level set of the named surface on the side of the ray.
};

}  // namespace kagero
