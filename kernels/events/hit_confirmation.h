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
    /// repeated tests therefore have a margin. Returns the lanes that have missed.
    template <class Refine>
    std::uint64_t confirm(DeferredEvents<V, Events>& d, std::uint64_t hits, const Refine& refine) const {
        constexpr int max_tests = 4;
        constexpr double margin = 1e-11;
        std::uint64_t missed = 0;
        for (int i = 0; i < max_tests && hits; ++i) {
            const Vec3<V> q = d.step.end.q(), v = d.step.end.velocity;
            const std::uint64_t confirmed = confirmed_hits<V>(geometry().surfaces, d.surface, d.primitive, hits, q, v,
                                                              1 / geometry().scale, i ? margin : 0);
            const std::uint64_t outside = hits & ~confirmed;
            const bool is_last = i + 1 == max_tests;
            const std::uint64_t found =
                outside && !is_last ? find_nearby(outside, q, v, d.surface, d.primitive) : 0;
            missed |= outside & ~found;
            if (found) {
                d.level_set.assign_lanes(from_bits<V>(found),
                                         level_sets_of<V>(geometry().surfaces, d.surface, d.primitive, found));
                hits = refine(found);
            } else hits = 0;
        }
        return missed;
    }

    /// Follows rays that pass close to a sphere to the point nearest to its centre. Returns the lanes that stay
    /// outside; their step ends at that point. For the others, the point bounds the position of the hit.
    std::uint64_t follow_grazing_rays(DeferredEvents<V, Events>& d, std::uint64_t hits) const {
        const MaskOf<V> spheres = from_bits<V>(hits) & (abs(d.level_set.a) > V(S(0)));
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
        const MaskOf<V> spheres = from_bits<V>(lanes) & (abs(d.level_set.a) > V(S(0))) &
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
    /// Searches for other triangles that the tangents x + t·v of `lanes` pass through close to x, or pass at the
    /// distance between tangent and ray. Sets their indices and returns the lanes in which one was found.
    std::uint64_t find_nearby(std::uint64_t lanes, const Vec3<V>& x, const Vec3<V>& v, std::uint32_t (&surface)[W],
                              std::uint32_t (&primitive)[W]) const {
        const double reach = 4 * (task_.job.chord_tolerance + embree_rounding / geometry().scale),
                     bending = 4 * reach * reach * geometry().scale;  // for radii of curvature above 1/8 of the size
        Segments<W> segments;
        const V half = V(S(reach)) / fast_sqrt(dot(v, v));
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
        const auto accepts = [&](int i, std::uint32_t candidate, std::uint32_t triangle, float) {
            const Surface& other = geometry().surfaces[candidate];
            if (other.kind == Surface::Kind::sphere) return false;
            if (candidate == surface[i] && triangle == primitive[i]) return false;
            const LevelSet<double> plane = level_set_of(other, triangle);
            const Vec3<double> at{double(get_lane(x.x, i)), double(get_lane(x.y, i)), double(get_lane(x.z, i))},
                velocity{double(get_lane(v.x, i)), double(get_lane(v.y, i)), double(get_lane(v.z, i))};
            const double distance = -plane.value(at) / dot(plane.normal, velocity);
            if (!(std::abs(distance) <= double(get_lane(half, i)))) return false;
            const Vec3<double> crossing = advance(at, distance, velocity);
            const double size = std::max({std::abs(at.x), std::abs(at.y), std::abs(at.z), 1 / geometry().scale});
            return bool(triangle_of(other, triangle)
                            .contains_line(crossing, velocity, max(4 * double(machine_epsilon<S>) * size, bending)));
        };
        std::uint64_t legal = lanes;
        for (const int i : lanes_in(lanes))
            if (!is_legal_segment(segments, i)) legal &= ~(std::uint64_t(1) << i);
        const std::uint64_t found = query_filtered(geometry().embree_scene, segments, legal, accepts);
        for (const int i : lanes_in(found)) {
            surface[i] = segments.surface[i];
            primitive[i] = segments.primitive[i];
        }
        return found;
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
        const V size = max(max(abs(q.x), abs(q.y)), abs(q.z)) + abs(sphere.center.x) + abs(sphere.center.y) +
                       abs(sphere.center.z) + fast_sqrt(sphere.radius2);
        return V(S(4) * machine_epsilon<S>) * size;
    }

    const Geometry& geometry() const { return *task_.job.geometry; }

    static constexpr int max_corrections = 12;
    /// Rounding error of a query, in Embree's coordinates.
    static constexpr double embree_rounding = 2e-6;

    const Task<V>& task_;
};

}  // namespace kagero
