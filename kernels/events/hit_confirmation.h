/// Confirms hits on bent rays. The chord of a piece of the path and the path itself are close, but the chord may meet a
/// surface that the path passes. After refinement, a ray therefore either passes through its triangle, or through
/// another one nearby, or it has missed the surface and continues. A ray that passes close to a sphere is followed to
/// the point nearest to the centre of the sphere.
#pragma once

#include "kernels/events/deferred_events.h"
#include "kernels/intersection/segment_query.h"
#include "kernels/intersection/triangle.h"

namespace kagero {

/// Tests hits of one packet against the exact surfaces.
template <class V, class Events>
class HitConfirmation {
    using S = ScalarOf<V>;
    static constexpr int W = lane_count<V>;

public:
    explicit HitConfirmation(const Task<V>& task) : task_(task) {}

    /// Confirms the refined hits of `hits`. A ray that passes its triangle on the outside hits another triangle nearby,
    /// or it has missed. `refine(lanes)` moves rays to the planes of other triangles, where they are tested again. The
    /// positions on two planes differ by the error of the method, so that a ray could pass between two triangles; the
    /// repeated tests therefore have a margin. A ray close to its start on a named surface has a greater margin if no
    /// other triangle is hit, since its start may lie beyond the edge of that surface by the margin. Returns the lanes
    /// that have missed; their step ends at the last of the planes on which they have passed a triangle.
    template <class Refine>
    std::uint64_t confirm(DeferredEvents<V, Events>& d, std::uint64_t hits, const Refine& refine) const {
        constexpr int max_tests = PassedPrimitives<W>::max_count;
        std::uint64_t missed = 0;
        StepEnd<V> farthest = d.step;
        V farthest_fraction(-std::numeric_limits<S>::max());
        SecondBest second_best;
        for (int i = 0; i < max_tests && hits; ++i) {
            const Vec3<V> q = d.step.end.q(), v = d.step.end.velocity;
            const auto confirmed_within = [&](std::uint64_t lanes, double distance) {
                return confirmed_hits<V>(geometry().surfaces, d.surface, d.primitive, lanes, q, v, 1 / geometry().scale,
                                         distance);
            };
            const std::uint64_t crossing = hits & ~comes_back(d, q, v);
            const std::uint64_t confirmed = confirmed_within(crossing & ~d.departing, i ? margin : 0) |
                                            confirmed_within(crossing & d.departing, margin);
            const std::uint64_t outside = hits & ~confirmed, starting = crossing & outside & d.departing;
            second_best.add(d, confirmed_within(starting & ~second_best.lanes, 100 * margin));
            for (const int lane : lanes_in(outside)) d.passed.add(lane, d.surface[lane], d.primitive[lane]);
            const MaskOf<V> farther = from_bits<V>(outside) & (d.event_fraction > farthest_fraction);
            farthest.copy_lanes(d.step, farther);
            farthest_fraction = select(farther, d.event_fraction, farthest_fraction);
            const bool is_last = i + 1 == max_tests;
            const std::uint64_t found = outside && !is_last ? find_nearby(outside, q, v, d) : 0;
            missed |= outside & ~found;
            if (found) {
                d.level_set.assign_lanes(from_bits<V>(found),
                                         level_sets_of<V>(geometry().surfaces, d.surface, d.primitive, found));
                hits = refine(found);
            } else hits = 0;
        }
        if (second_best.lanes) missed &= ~second_best.restore(d, missed);
        static_cast<StepEnd<V>&>(d.step).copy_lanes(farthest, from_bits<V>(missed));
        d.event_fraction = select(from_bits<V>(missed), farthest_fraction, d.event_fraction);
        return missed;
    }

    /// Follows rays that pass close to a sphere to the point nearest to its centre. Returns the lanes that stay
    /// outside; their step ends at that point. For the others, the point bounds the position of the hit.
    std::uint64_t follow_grazing_rays(DeferredEvents<V, Events>& d, std::uint64_t hits) const {
        const MaskOf<V> spheres = from_bits<V>(hits & ~d.inside) & (abs(d.level_set.a) > V(S(0)));
        V closest;
        const MaskOf<V> rays = grazing(d, spheres, closest);
        if (!any(rays)) return 0;
        const Step<V> whole_step = d.step;
        const V full_length = d.step.h;
        const MaskOf<V> found = move_to_closest(d.step, d.level_set, rays, full_length, closest);
        const Vec3<V> q = d.step.end.q();
        const MaskOf<V> is_outside = d.level_set.value(q) > -height_rounding(d.level_set, q);
        const std::uint64_t missed = to_bits(rays & found & is_outside);
        const V entry =
            closest + d.level_set.intersect_line(q, d.step.end.velocity, all_lanes<V>()).line_parameter / full_length;
        d.step.copy_lanes(whole_step, rays & !from_bits<V>(missed));
        d.step.h = full_length;
        const MaskOf<V> hit = rays & found & !is_outside;
        d.hi = select(hit, closest, d.hi);
        d.event_fraction = select(hit, max(entry, d.lo), d.event_fraction);
        return missed;
    }

    /// Follows those of `lanes` that have hit a sphere from outside to the point nearest to its centre. Returns the
    /// lanes that stay outside; their step ends at that point. The other lanes are not changed.
    std::uint64_t follow_unsure_rays(DeferredEvents<V, Events>& d, const Step<V>& whole_step,
                                     std::uint64_t lanes) const {
        const MaskOf<V> spheres = from_bits<V>(lanes & ~d.inside) & (abs(d.level_set.a) > V(S(0))) &
                                  (d.level_set.value(whole_step.start.q()) >= V(S(0)));
        if (!any(spheres)) return 0;
        StepperState<V> step = d.step;
        step.copy_lanes(whole_step, spheres);
        V closest = d.event_fraction;
        const MaskOf<V> found = move_to_closest(step, d.level_set, spheres, whole_step.h, closest);
        const Vec3<V> q = step.end.q();
        const MaskOf<V> passing =
            spheres & found & (d.level_set.value(q) > -height_rounding(d.level_set, q));
        static_cast<StepEnd<V>&>(d.step).copy_lanes(step, passing);
        return to_bits(passing);
    }

private:
    /// Hits of rays close to their start that are outside of their triangle by a little more than the margin.
    struct SecondBest {
        std::uint64_t lanes = 0;
        StepEnd<V> end;
        V fraction{S(0)};
        std::uint32_t surface[W], primitive[W];

        /// Stores the current hits of the lanes `added`.
        void add(const DeferredEvents<V, Events>& d, std::uint64_t added) {
            if (!added) return;
            if (!lanes) end = d.step;
            end.copy_lanes(d.step, from_bits<V>(added));
            fraction = select(from_bits<V>(added), d.event_fraction, fraction);
            lanes |= added;
            for (const int i : lanes_in(added)) {
                surface[i] = d.surface[i];
                primitive[i] = d.primitive[i];
            }
        }
        /// Makes the stored hits of `wanted` the current ones. Returns the lanes that have one.
        std::uint64_t restore(DeferredEvents<V, Events>& d, std::uint64_t wanted) const {
            const std::uint64_t restored = wanted & lanes;
            static_cast<StepEnd<V>&>(d.step).copy_lanes(end, from_bits<V>(restored));
            d.event_fraction = select(from_bits<V>(restored), fraction, d.event_fraction);
            for (const int i : lanes_in(restored)) {
                d.surface[i] = surface[i];
                d.primitive[i] = primitive[i];
            }
            return restored;
        }
    };

    /// Returns the lanes whose ray comes back at q through the plane that it has hit, to the side where the piece
    /// begins. It has entered the surface by less than the chord tolerance, and Newton's method has found the second
    /// crossing.
    std::uint64_t comes_back(const DeferredEvents<V, Events>& d, const Vec3<V>& q, const Vec3<V>& v) const {
        const V before = d.level_set.value(d.curve.at(d.lo)), speed = d.level_set.slope(q, v), zero(S(0)),
                smallest(std::max(S(1e-10), S(64) * machine_epsilon<S>) * S(1 / geometry().scale));
        return to_bits((abs(d.level_set.a) <= zero) & (abs(before) > smallest) & (before * speed > zero));
    }
    /// Searches for other triangles that the tangents x + t·v of `lanes` pass through close to x, or pass at the
    /// distance between tangent and ray. Sets their indices and returns the lanes in which one was found.
    std::uint64_t find_nearby(std::uint64_t lanes, const Vec3<V>& x, const Vec3<V>& v,
                              DeferredEvents<V, Events>& d) const {
        const double tolerance = task_.job.chord_tolerance, size = 1 / geometry().scale;
        const std::uint64_t found = find_within(V(S(4 * (tolerance + embree_rounding * size))), lanes, x, v, d);
        if (found == lanes) return found;
        // A ray that is nearly parallel to a triangle may cross it farther away. Between the start of the piece and x,
        // it may also have crossed another triangle.
        const Vec3<V> piece = x - d.curve.at(d.lo);
        const V length = fast_sqrt(dot(piece, piece));
        const V reach = max(select(is_finite(length), length, V(S(0))), V(S(std::sqrt(tolerance * size))));
        return found | find_within(reach, lanes & ~found, x, v, d);
    }
    /// Searches for triangles up to the distance `least_reach` from x, or up to four times the distance of x from the
    /// dense output if that is greater: a hit is found on the dense output, which is less accurate than x in a long
    /// step.
    std::uint64_t find_within(const V& least_reach, std::uint64_t lanes, const Vec3<V>& x, const Vec3<V>& v,
                              DeferredEvents<V, Events>& d) const {
        std::uint32_t(&surface)[W] = d.surface;
        std::uint32_t(&primitive)[W] = d.primitive;
        const Vec3<V> to_curve = x - d.curve.at(d.event_fraction);
        const V deviation = fast_sqrt(dot(to_curve, to_curve)),
                reach = least_reach + select(is_finite(deviation), V(S(4)) * deviation, V(S(0)));
        Segments<W> segments;
        const V half = reach / fast_sqrt(dot(v, v));
        const Vec3<V> from = advance(x, -half, v), whole = (half + half) * v;
        const auto set_axis = [&](const V& start, const V& difference, int k) {
            to_doubles(start, segments.exact_org[k]);
            to_doubles(difference, segments.exact_dir[k]);
            for (int i = 0; i < W; ++i) {
                segments.org[k][i] = float((segments.exact_org[k][i] - geometry().shift[k]) * geometry().scale);
                segments.dir[k][i] = float(segments.exact_dir[k][i] * geometry().scale);
            }
        };
        set_axis(from.x, whole.x, 0);
        set_axis(from.y, whole.y, 1);
        set_axis(from.z, whole.z, 2);
        std::fill_n(segments.near, W, 0.0f);
        const double rounding = std::max(4 * double(machine_epsilon<S>), margin);  // in units of the scene's size
        bool allows_bending = false;  // the second search also accepts tangents at the distance between tangent and ray
        const auto accepts = [&](int i, std::uint32_t candidate, std::uint32_t triangle, float) {
            const Surface& other = geometry().surfaces[candidate];
            if (other.kind == Surface::Kind::sphere) return false;
            if (d.passed.contains(i, candidate, triangle)) return false;
            const LevelSet<double> plane = level_set_of(other, triangle);
            const bool is_departing = ((d.departing >> i) & 1) != 0;
            if (is_departing && comes_from_behind(d, i, triangle_of(other, triangle), plane, v)) return false;
            const Vec3<double> at{double(get_lane(x.x, i)), double(get_lane(x.y, i)), double(get_lane(x.z, i))},
                velocity{double(get_lane(v.x, i)), double(get_lane(v.y, i)), double(get_lane(v.z, i))};
            const double distance = -plane.value(at) / dot(plane.normal, velocity);
            if (!(std::abs(distance) <= double(get_lane(half, i)))) return false;
            const Vec3<double> crossing = advance(at, distance, velocity);
            const double lane_reach = double(get_lane(reach, i)),  // for radii of curvature above 1/8 of the size
                bending = allows_bending ? 4 * lane_reach * lane_reach * geometry().scale : 0;
            const double size = std::max(greatest_component(at), 1 / geometry().scale);
            return bool(
                triangle_of(other, triangle).contains_line(crossing, velocity, std::max(rounding * size, bending)));
        };
        std::uint64_t legal = lanes;
        for (const int i : lanes_in(lanes))
            if (!is_legal_segment(segments, i)) legal &= ~(std::uint64_t(1) << i);
        std::uint64_t found = query_around(geometry().embree_scene, segments, legal, accepts);
        allows_bending = true;
        if (legal != found) found |= query_around(geometry().embree_scene, segments, legal & ~found, accepts);
        for (const int i : lanes_in(found)) {
            surface[i] = segments.surface[i];
            primitive[i] = segments.primitive[i];
        }
        return found;
    }

    /// Returns true if the ray of a lane, which starts on a named triangle with the velocity v, cannot cross another
    /// triangle close to its start: that one lies behind the named triangle, or the named triangle lies on the side of
    /// `plane` to which the ray moves. If both triangles have a common corner, the centre of the named one decides.
    bool comes_from_behind(const DeferredEvents<V, Events>& d, int i, const Triangle<double>& triangle,
                           const LevelSet<double>& plane, const Vec3<V>& v) const {
        const Surface& start = geometry().surfaces[d.start_surface[i]];
        if (start.kind == Surface::Kind::sphere) return false;
        const Vec3<double> velocity{double(get_lane(v.x, i)), double(get_lane(v.y, i)), double(get_lane(v.z, i))};
        const LevelSet<double> own = level_set_of(start, d.start_primitive[i]);
        const double leaving = dot(own.normal, velocity) < 0 ? -1 : 1;
        double reach = 0;
        for (const Vec3<double>& corner : triangle.corner) reach = std::max(reach, leaving * own.value(corner));
        if (!(reach > margin / geometry().scale)) return true;
        const double direction = dot(plane.normal, velocity) > 0 ? -1 : 1;
        const Triangle<double> named = triangle_of(start, d.start_primitive[i]);
        double greatest = direction * plane.value(named.center());
        for (const Vec3<double>& corner : named.corner)
            if (!named.has_common_corner(triangle)) greatest = std::max(greatest, direction * plane.value(corner));
        return !(greatest > margin / geometry().scale);
    }

    /// Returns the lanes of `spheres` whose step does not clearly cross its sphere: it begins outside, the least height
    /// of the dense output between the fractions lo and hi is greater than −depth, and the ray ends outside or moves
    /// away again. Sets `closest` to the fraction of the point nearest to the centre.
    MaskOf<V> grazing(const DeferredEvents<V, Events>& d, const MaskOf<V>& spheres, V& closest) const {
        const Curve<V>& curve = d.curve;
        const LevelSet<V>& sphere = d.level_set;
        const V &lo = d.lo, &hi = d.hi;
        const V zero(S(0)), depth(S(4 * task_.job.chord_tolerance + 1e-6 / geometry().scale));
        closest = d.event_fraction;
        for (int i = 0; i < 6; ++i) {
            const Vec3<V> slope = curve.slope(closest);
            const V next = closest - dot(curve.at(closest) - sphere.center, slope) / dot(slope, slope);
            closest = select(spheres & is_finite(next), min(max(next, lo), hi), closest);
        }
        const MaskOf<V> turns_back = closest < hi - V(S(1e-3)) * (hi - lo);
        const MaskOf<V> starts_outside = sphere.value(d.step.start.q()) >= zero,
                        ends_outside = sphere.value(curve.at(hi)) >= zero;
        return spheres & starts_outside & (turns_back | ends_outside) & (sphere.value(curve.at(closest)) > -depth);
    }

    /// Moves the rays of `lanes` to the points of their paths nearest to the centres of their spheres, by partial steps
    /// of `step`. `fraction` is the estimated fraction of the step; it is set to the exact one. Returns the lanes in
    /// which such a point was found.
    MaskOf<V> move_to_closest(StepperState<V>& step, const LevelSet<V>& sphere, const MaskOf<V>& lanes,
                              const V& full_length, V& fraction) const {
        const V zero(S(0)), limit(S(std::is_same_v<S, float> ? 1e-5 : 1e-9));
        StepEnd<V> ends = step;
        step.h = select(lanes, fraction * full_length, zero);
        if (!task_.steps_without_begin) task_.begin(step);
        MaskOf<V> open = lanes, valid = lanes;
        V last_rate(zero), last_correction(zero);
        for (int i = 0; i < max_corrections; ++i) {
            if (i == 0) task_.step(step);
            else task_.correction_step(step);
            ends.copy_lanes(step, open);
            valid = valid & (step.solved | !open) & (step.energy_is_conserved | !open);
            const Vec3<V> v = step.end.velocity;
            const V rate = dot(step.end.q() - sphere.center, v), straight = -rate / dot(v, v);
            const V secant = -rate * last_correction / (rate - last_rate);
            const MaskOf<V> is_usable = is_finite(secant) & (abs(secant) < abs(full_length));
            const V correction = i == 0 ? straight : select(is_usable, secant, straight);
            valid = valid & ((!open) | (is_finite(correction) & (abs(correction) < abs(full_length))));
            open = open & valid & (abs(correction) > limit * abs(full_length));
            if (!any(open)) break;
            task_.begin_next(step, lanes);
            step.h = select(open, correction, zero);
            fraction = select(open, fraction + correction / full_length, fraction);
            last_rate = rate;
            last_correction = correction;
        }
        static_cast<StepEnd<V>&>(step).copy_lanes(ends, lanes);
        return valid & !open;
    }

    /// Returns the rounding error of a height above the sphere.
    V height_rounding(const LevelSet<V>& sphere, const Vec3<V>& q) const {
        const V size = greatest_component(q) + abs(sphere.center.x) + abs(sphere.center.y) + abs(sphere.center.z) +
                       fast_sqrt(sphere.radius2);
        return V(S(4) * machine_epsilon<S>) * size;
    }

    const Geometry& geometry() const { return *task_.job.geometry; }

    static constexpr int max_corrections = 12;
    /// Distance at which a ray may pass a triangle in repeated tests, in units of the scene's size.
    static constexpr double margin = 1e-11;
    /// Rounding error of a query, in Embree's coordinates.
    static constexpr double embree_rounding = 2e-6;

    const Task<V>& task_;
};

}  // namespace kagero
