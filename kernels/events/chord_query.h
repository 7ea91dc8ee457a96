/// Intersects chords with the scene by Embree, and confirms the hits of straight rays. Embree's query is in float; the
/// rules in this file make its result independent of that rounding close to the surfaces from which rays start.
#pragma once

#include "kernels/events/surface_hits.h"
#include "kernels/events/surface_starts.h"
#include "kernels/intersection/passed_primitives.h"
#include "kernels/intersection/segment_clipping.h"
#include "kernels/intersection/triangle.h"
#include "kernels/methods/task.h"

#include <algorithm>
#include <cmath>

namespace kagero {

/// Intersects one chord of each ray of a packet with the scene.
template <class V>
class ChordQuery {
    using S = ScalarOf<V>;
    static constexpr int W = lane_count<V>;

public:
    SurfaceHits<V> hits;  ///< Valid in the lanes that the last call of `query` has returned.

    explicit ChordQuery(const Task<V>& task)
        : task_(task), geometry_(*task.job.geometry), chord_only_(task.job.hit == HitModel::chord), starts_(geometry_),
          starts_off_surfaces_(starts_off_surfaces()) {}

    /// Initializes `lanes` for new rays. The surface on which a ray starts does not count as hit. The rays of
    /// `on_surface` start on the given surfaces.
    void begin(std::uint64_t lanes, std::uint64_t on_surface, const std::uint32_t* surface,
               const std::uint32_t* primitive) {
        starts_.begin(lanes, on_surface, surface, primitive);
        queries_ = select(from_bits<V>(lanes), V(S(0)), queries_);
        departing_ &= ~lanes;
        has_passed_ &= ~lanes;
        ignore_surface_at_start(lanes);
    }
    /// Ignores a surface on which the next step of `lanes` starts.
    void ignore_surface_at_start(std::uint64_t lanes) {
        starts_.restart(lanes);
        if (!starts_off_surfaces_) may_start_on_surface_ |= lanes & ~starts_.named();
    }

    /// Ignores, in the next query of `lanes`, the primitives that their rays have just passed without hitting them.
    void ignore_passed(std::uint64_t lanes, const PassedPrimitives<W>& passed) {
        for (const int i : lanes_in(lanes)) passed_.copy_lane(i, passed);
        has_passed_ |= lanes;
    }

    /// Called after steps of `lanes` that were not queried: their next segment does not start on a surface.
    void leave_surfaces(std::uint64_t lanes) {
        may_start_on_surface_ &= ~lanes;
        starts_.leave(lanes);
    }
    /// Returns the named surfaces on which the rays start.
    SurfaceStarts<V>& starts() { return starts_; }
    const SurfaceStarts<V>& starts() const { return starts_; }

    /// Returns the surfaces that `lanes` have hit.
    LevelSet<V> level_sets(std::uint64_t lanes) const {
        return level_sets_of<V>(geometry_.surfaces, hits.surface, hits.primitive, lanes);
    }
    /// Returns the number of queries of each ray.
    const V& queries() const { return queries_; }

    /// Queries the segments a → b, which are the chords of the pieces [s0, s1] of the steps in lanes `open`. Sets
    /// `hits` in the lanes that hit a surface and returns these lanes. If the rays are straight (`exact`), each hit is
    /// confirmed in the packet's precision.
    template <bool exact = false>
    std::uint64_t query(const Vec3<V>& a, const Vec3<V>& b, const V& s0, const V& s1, std::uint64_t open) {
        const std::uint64_t may_start_on_surface = open & may_start_on_surface_, passed = open & has_passed_,
                            on_named = open & (starts_.departing() | starts_.returning()),
                            near_start = may_start_on_surface | passed | on_named | (open & departing_);
        may_start_on_surface_ &= ~open;
        hits.departing &= ~open;
        departing_ &= ~open;
        has_passed_ &= ~open;
        Segments<W> segments;
        V begin(S(0)), length(S(1)), extension(S(0));  // the queried segment, in fractions of the chord
        if (near_start || !exact) extension = extension_of(b - a);
        if (near_start) begin = select(from_bits<V>(near_start), -extension, begin);
        length = exact ? V(S(1)) - begin : V(S(1)) + extension - begin;
        const Vec3<V> query_start = near_start ? advance(a, begin, b - a) : a,
                      query_end = exact ? b : advance(b, extension, b - a);
        const V scale(S(geometry_.scale));
        V size(S(0));  // greatest absolute coordinate of both ends, in Embree's coordinates
        const auto to_embree = [&](const V& start, const V& end, int k) {
            const V shift(S(geometry_.shift[k])), embree_start = (start - shift) * scale,
                    embree_end = (end - shift) * scale;
            size = max(size, max(abs(embree_start), abs(embree_end)));
            to_floats(embree_start, segments.org[k]);
            to_floats((end - start) * scale, segments.dir[k]);
        };
        to_embree(query_start.x, query_end.x, 0);
        to_embree(query_start.y, query_end.y, 1);
        to_embree(query_start.z, query_end.z, 2);
        std::fill_n(segments.near, W, 0.0f);
        std::fill_n(segments.t, W, 0.0f);
        if (geometry_.has_spheres) {
            const Vec3<V> whole = query_end - query_start;
            to_doubles(query_start.x, segments.exact_org[0]);
            to_doubles(query_start.y, segments.exact_org[1]);
            to_doubles(query_start.z, segments.exact_org[2]);
            to_doubles(whole.x, segments.exact_dir[0]);
            to_doubles(whole.y, segments.exact_dir[1]);
            to_doubles(whole.z, segments.exact_dir[2]);
            const double greatest = greatest_margin / geometry_.scale;
            segments.margin = exact || chord_only_ ? 0 : std::min(task_.job.chord_tolerance, greatest);
            for (int i = 0; i < W; ++i) segments.ignored[i] = (passed >> i) & 1 ? passed_.surface[0][i] : no_surface;
        }
        skip_outside_escape_sphere(task_.escape_radius, query_start, query_end, segments);
        for (const int i : lanes_in(open & ~to_bits(size < V(S(clip_size))))) {
            if (!clip(geometry_, a, b, i, segments, begin, length)) open &= ~(std::uint64_t(1) << i);
        }
        queries_ = select(from_bits<V>(open), queries_ + V(S(1)), queries_);
        // A ray that departs from a named triangle ignores it. Only hits that are not clear need the rules of
        // `starts_`.
        const IgnoredTriangles ignored = starts_.departing_from_triangles(exact || !chord_only_ ? open : 0);
        std::uint64_t by_rules = open & on_named & ~ignored.lanes;
        std::uint64_t hit = kagero::query(geometry_.embree_scene, segments, open & ~by_rules, ignored);
        std::uint64_t clear = hit & ignored.lanes;
        if (clear) clear = clear_hits<exact>(a, b, begin, length, extension, segments, clear);
        by_rules |= hit & ignored.lanes & ~clear;
        hit &= ~ignored.lanes;
        std::uint64_t unsure = hit & near_start;
        if (hit && !exact) unsure |= hit & to_bits(fractions_of(segments, begin, length) > V(S(1)) - extension);
        if (unsure)
            hit = remove_outside_segment(a, b, begin, length, segments, hit, unsure, may_start_on_surface, passed);
        if constexpr (exact) hit = confirm(a, b, begin, length, segments, hit, near_start, may_start_on_surface);
        V returns_at(S(2));
        hit |= clear;
        if (by_rules) hit |= query_by_rules<exact>(a, b, begin, length, segments, by_rules, returns_at);
        if (on_named) end_segments_on_named(open & on_named, hit);
        if (!hit) return 0;
        const MaskOf<V> mask = from_bits<V>(hit);
        const V fractions = fractions_of(segments, begin, length);
        hits.t = select(mask, select(returns_at <= V(S(1)), returns_at, fractions), hits.t);
        hits.piece_start = select(mask, s0, hits.piece_start);
        hits.piece_end = select(mask, s1, hits.piece_end);
        for (int i = 0; i < W; ++i) {
            const bool is_hit = (hit >> i) & 1;
            hits.surface[i] = is_hit ? segments.surface[i] : hits.surface[i];
            hits.primitive[i] = is_hit ? segments.primitive[i] : hits.primitive[i];
        }
        return hit;
    }

private:
    /// Returns the length, as a fraction of the chord, by which a query extends beyond the end of a piece, and, close
    /// to surfaces, before its start. Without it, Embree could miss surfaces close to the ends of two successive pieces
    /// because of its rounding in float.
    V extension_of(const Vec3<V>& chord) const {
        const V offset(S(double(end_offset) / geometry_.scale));
        return offset / max(fast_sqrt(dot(chord, chord)), V(S(1e-3)) * offset);
    }
    /// Returns the greatest fraction of a chord at which a hit counts as one of this piece, up to rounding.
    template <class T>
    static T greatest_fraction(const T& extension) {
        return fma(T(ScalarOf<T>(std::is_same_v<S, float> ? 0.1 : 1e-8)), extension, T(ScalarOf<T>(1)));
    }
    /// Converts the positions t on the queried segments to fractions of the chords a → b.
    static V fractions_of(const Segments<W>& segments, const V& begin, const V& length) {
        alignas(64) double fraction[W];
        std::copy_n(segments.t, W, fraction);
        return fma(length, lanes_of<V>(fraction), begin);
    }

    /// Removes the hits of surfaces from which rays depart, and hits beyond the end of a piece, since Embree's floats
    /// cannot show on which side of a close surface a piece begins or ends. Such lanes are queried again, and each
    /// candidate hit is tested in double precision. Returns the lanes of `hit` that still hit a surface. The hits of
    /// the lanes `close` are close to an end of the segment; the lanes `may_start_on_surface` may start on a surface.
    std::uint64_t remove_outside_segment(const Vec3<V>& a, const Vec3<V>& b, const V& begin, const V& length,
                                         Segments<W>& segments, std::uint64_t hit, std::uint64_t close,
                                         std::uint64_t may_start_on_surface, std::uint64_t passed) {
        // A hit within rounding of the end of the piece belongs to it, since the next piece departs from the surface.
        const V rounding = starts_.rounding_at(a), chord = norm(b - a), least = extension_of(b - a),
                greatest = greatest_fraction(least) + rounding / max(chord, rounding);
        const LevelSet<V> level_sets =
            level_sets_of<V>(geometry_.surfaces, segments.surface, segments.primitive, close);
        const V fraction = chord_fraction(level_sets, a, b, fractions_of(segments, begin, length));
        std::uint64_t departed = close & to_bits(departs(level_sets, a, b, fraction, least, starts_.rounding_at(a),
                                                         from_bits<V>(may_start_on_surface)) |
                                                 (fraction > greatest));
        for (const int i : lanes_in(passed & hit))
            if (has_passed(i, segments.surface[i], segments.primitive[i])) departed |= std::uint64_t(1) << i;
        if (!departed) return hit;
        departing_ |= departed;
        const auto accepts = [&](int i, std::uint32_t surface, std::uint32_t primitive, float t) {
            if (((passed >> i) & 1) != 0 && has_passed(i, surface, primitive)) return false;
            const double near = double(get_lane(length, i)) * double(t) + double(get_lane(begin, i));
            const LevelSet<double> level_set = level_set_of(geometry_.surfaces[surface], primitive);
            const Vec3<double> from = lane_of(a, i), to = lane_of(b, i);
            const double at = chord_fraction(level_set, from, to, near);
            return at <= double(get_lane(greatest, i)) &&
                   !departs(level_set, from, to, at, double(get_lane(least, i)), starts_.rounding_at(from),
                            ((may_start_on_surface >> i) & 1) != 0);
        };
        return (hit & ~departed) | query_filtered(geometry_.embree_scene, segments, departed, accepts);
    }

    /// Returns those of `lanes`, whose rays depart from named triangles, in which the hit of the query is certain: it
    /// lies off all surfaces at the start and off the end of the segment, and a straight ray passes through its
    /// triangle.
    template <bool exact>
    std::uint64_t clear_hits(const Vec3<V>& a, const Vec3<V>& b, const V& begin, const V& length, const V& extension,
                             const Segments<W>& segments, std::uint64_t lanes) const {
        const LevelSet<V> g = level_sets_of<V>(geometry_.surfaces, segments.surface, segments.primitive, lanes);
        const V fraction = chord_fraction(g, a, b, fractions_of(segments, begin, length)), one(S(1));
        const std::uint64_t clear = starts_.hits_clearly(lanes, g, a, b, fraction) &
                                    to_bits((fraction > V(S(2)) * extension) & (fraction < one - extension));
        if (!exact || !clear) return clear;
        return confirmed_hits<V>(geometry_.surfaces, segments.surface, segments.primitive, clear,
                                 advance(a, fraction, b - a), b - a, 1 / geometry_.scale);
    }
    /// Stores that segments of `lanes` have left the named surfaces where they begin. Lanes of `hit` have hit a
    /// surface.
    void end_segments_on_named(std::uint64_t lanes, std::uint64_t hit) {
        hits.departing |= hit & lanes & starts_.departing();
        departing_ |= lanes & ~hit;
        starts_.end_segments(lanes);
    }

    /// Queries the segments of `lanes`, which begin on the named surface where the ray starts, or begin to return to
    /// it. Each candidate hit is tested by the rules of `starts_`. Returns the lanes that hit a surface. Sets
    /// `returns_at` to the fractions of the chords at which rays hit their named surface.
    template <bool exact>
    std::uint64_t query_by_rules(const Vec3<V>& a, const Vec3<V>& b, const V& begin, const V& length,
                                 Segments<W>& segments, std::uint64_t lanes, V& returns_at) {
        const std::uint64_t departing = lanes & starts_.departing();
        const bool straight = exact || chord_only_;
        for (const int i : lanes_in(straight ? departing : 0)) starts_.set_side(i, lane_of(a, i), lane_of(b - a, i));
        std::uint64_t beside = 0;  // lanes that pass a neighbor of their triangle closely on the outside
        bool accepts_beside = false;
        const auto accepts = [&](int i, std::uint32_t surface, std::uint32_t primitive, float t) {
            if (starts_.is_named(i, surface, primitive)) return false;
            const double near = double(get_lane(length, i)) * double(t) + double(get_lane(begin, i));
            const Surface& other = geometry_.surfaces[surface];
            const Vec3<double> from = lane_of(a, i), to = lane_of(b, i);
            const double at = chord_fraction(level_set_of(other, primitive), from, to, near);
            if (at > greatest_fraction(double(get_lane(begin, i)) * -1)) return false;
            if (!starts_.can_hit(i, surface, primitive, from, to, at)) return false;
            const Vec3<double> x = advance(from, at, to - from);
            if (!straight || contains(other, primitive, x, to - from, 0)) return true;
            if (!starts_.is_neighbor(i, surface, primitive)) return false;
            if (!contains(other, primitive, x, to - from, 1e-9 / geometry_.scale)) return false;
            beside |= std::uint64_t(1) << i;
            return accepts_beside && at * at * dot(to - from, to - from) * geometry_.scale * geometry_.scale < 1e-12;
        };
        std::uint64_t hit = query_filtered(geometry_.embree_scene, segments, lanes, accepts);
        if (beside) {
            hit |= query_around(geometry_.embree_scene, segments, std::uint64_t(beside), accepts);
            // A start beyond the edge of its triangle by rounding may lie outside of all neighbors, but close to them.
            accepts_beside = true;
            const V near_start = begin + V(S(2)) * extension_of(b - a);
            const std::uint64_t near = hit & to_bits(fractions_of(segments, begin, length) < near_start);
            hit |= query_around(geometry_.embree_scene, segments, beside & ~near, accepts);
        }
        alignas(64) double fraction[W];
        to_doubles(fractions_of(segments, begin, length), fraction);
        for (const int i : lanes_in(hit))
            fraction[i] = chord_fraction(level_set_of(geometry_.surfaces[segments.surface[i]], segments.primitive[i]),
                                         lane_of(a, i), lane_of(b, i), fraction[i]);
        const double reach = 4 * task_.job.chord_tolerance;
        for (const int i : lanes_in(lanes)) {
            const bool can_return = straight || ((departing >> i) & 1) == 0;
            const Vec3<double> from = lane_of(a, i), to = lane_of(b, i);
            const double at = can_return ? starts_.return_fraction(i, from, to, straight) : 2;
            if (!(at <= 1) || (((hit >> i) & 1) != 0 && fraction[i] < at)) continue;
            const Surface& named = geometry_.surfaces[starts_.surface(i)];
            if (!contains(named, starts_.primitive(i), advance(from, at, to - from), to - from, reach)) continue;
            segments.surface[i] = starts_.surface(i);
            segments.primitive[i] = starts_.primitive(i);
            set_lane(returns_at, i, S(at));
            hit |= std::uint64_t(1) << i;
        }
        return hit;
    }
    /// Returns true if the line x + t·v passes through this triangle, or within `margin` of it, or if the surface is a
    /// sphere.
    bool contains(const Surface& surface, std::uint32_t primitive, const Vec3<double>& x, const Vec3<double>& v,
                  double margin) const {
        if (surface.kind == Surface::Kind::sphere) return true;
        return bool(triangle_of(surface, primitive).contains_line(x, v, std::max(margin, starts_.rounding_at(x))));
    }

    /// Confirms the hits of straight rays. Lanes whose ray passes its triangle on the outside are queried again, and
    /// each candidate hit is then tested in double precision. Returns the lanes of `hit` that hit a surface.
    std::uint64_t confirm(const Vec3<V>& a, const Vec3<V>& b, const V& begin, const V& length, Segments<W>& segments,
                          std::uint64_t hit, std::uint64_t near_start, std::uint64_t may_start_on_surface) {
        if (!hit) return 0;
        const LevelSet<V> level_sets = level_sets_of<V>(geometry_.surfaces, segments.surface, segments.primitive, hit);
        const V fraction = chord_fraction(level_sets, a, b, fractions_of(segments, begin, length));
        const double size = 1 / geometry_.scale;
        const std::uint64_t confirmed =
            confirmed_hits<V>(geometry_.surfaces, segments.surface, segments.primitive, hit,
                              advance(a, fraction, b - a), b - a, size);
        if (confirmed == hit) return hit;
        const V least = extension_of(b - a);
        const auto accepts = [&](int i, std::uint32_t surface, std::uint32_t primitive, float t) {
            const double near = double(get_lane(length, i)) * double(t) + double(get_lane(begin, i));
            const Surface& candidate = geometry_.surfaces[surface];
            const LevelSet<double> level_set = level_set_of(candidate, primitive);
            const Vec3<double> from = lane_of(a, i), to = lane_of(b, i);
            const double at = chord_fraction(level_set, from, to, near);
            if (((near_start >> i) & 1) != 0 &&
                departs(level_set, from, to, at, double(get_lane(least, i)), starts_.rounding_at(from),
                        ((may_start_on_surface >> i) & 1) != 0))
                return false;
            return contains(candidate, primitive, advance(from, at, to - from), to - from, 0);
        };
        return confirmed | query_around(geometry_.embree_scene, segments, hit & ~confirmed, accepts);
    }

    /// Returns true if the ray of a lane has just passed this triangle.
    bool has_passed(int lane, std::uint32_t surface, std::uint32_t primitive) const {
        return passed_.contains(lane, surface, primitive) &&
               geometry_.surfaces[surface].kind == Surface::Kind::triangles;
    }

    /// Returns true if no ray starts on a surface: the distance of the camera from every surface is large compared with
    /// the rounding of Embree's floats and of the packet's number type.
    bool starts_off_surfaces() const {
        const CameraRays* camera = task_.job.camera;
        if (!camera) return false;
        const auto [x, y, z] = camera->position;
        const double size = greatest_component(Vec3<double>{x, y, z}) + 1 / geometry_.scale;
        return camera->clearance > 2 * double(end_offset) / geometry_.scale + 16 * double(machine_epsilon<S>) * size;
    }

    /// Distance from a surface below which floats do not distinguish its sides, in Embree's coordinates. It is about 30
    /// rounding errors of a coordinate of order one.
    static constexpr float end_offset = 4e-6f;

    const Task<V>& task_;
    const Geometry& geometry_;
    bool chord_only_;           ///< True if each step is intersected as its chord.
    SurfaceStarts<V> starts_;   ///< The named surfaces on which rays start.
    bool starts_off_surfaces_;  ///< True if no ray starts on a surface.
    V queries_ = S(0);
    /// Lanes whose next segment may start on a surface: the first segment of a ray, or the first one after an event
    /// that has changed the state of the ray.
    std::uint64_t may_start_on_surface_ = 0;
    std::uint64_t has_passed_ = 0;  ///< Lanes whose ray has just passed primitives, which the next query ignores.
    PassedPrimitives<W> passed_;
    std::uint64_t departing_ = 0;           ///< Lanes whose previous piece has departed from a close surface.
};

}  // namespace kagero
