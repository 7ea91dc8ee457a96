/// Intersects chords with the scene by Embree, and confirms the hits of straight rays. Embree's query is in float; the
/// rules in this file make its result independent of that rounding close to the surfaces from which rays start.
#pragma once

#include "kernels/intersection/segment_query.h"
#include "kernels/intersection/triangle.h"
#include "kernels/methods/task.h"

#include <algorithm>
#include <cmath>

namespace kagero {

/// Returns lane i of a vector, in double precision.
template <class V>
Vec3<double> lane_of(const Vec3<V>& v, int i) {
    return {double(get_lane(v.x, i)), double(get_lane(v.y, i)), double(get_lane(v.z, i))};
}

/// The surfaces that the lanes of a packet have hit.
template <class V>
struct SurfaceHits {
    std::uint32_t surface[lane_count<V>] = {}, primitive[lane_count<V>] = {};
    V piece_start{ScalarOf<V>(0)}, piece_end{ScalarOf<V>(0)};  ///< Ends of the hit piece, as fractions of the step.
    V t{ScalarOf<V>(0)};  ///< Embree's position of the hit, as a fraction of the chord of that piece.

    /// Returns the approximate position of the hit, as a fraction of the step.
    V hit_fraction() const { return fma(t, piece_end - piece_start, piece_start); }
};

/// Intersects one chord of each ray of a packet with the scene.
template <class V>
class ChordQuery {
    using S = ScalarOf<V>;
    static constexpr int W = lane_count<V>;

public:
    SurfaceHits<V> hits;  ///< Valid in the lanes that the last call of `query` has returned.

    explicit ChordQuery(const Task<V>& task)
        : task_(task), geometry_(*task.job.geometry), chord_only_(task.job.hit == HitModel::chord),
          starts_off_surfaces_(starts_off_surfaces()) {}

    /// Initializes `lanes` for new rays. The surface on which a ray starts does not count as hit.
    void begin(std::uint64_t lanes) {
        queries_ = select(from_bits<V>(lanes), V(S(0)), queries_);
        departing_ &= ~lanes;
        has_passed_ &= ~lanes;
        ignore_surface_at_start(lanes);
    }
    /// Ignores a surface on which the next step of `lanes` starts.
    void ignore_surface_at_start(std::uint64_t lanes) {
        if (!starts_off_surfaces_) may_start_on_surface_ |= lanes;
    }

    /// Ignores, in the next query of `lanes`, the primitives that their rays have just passed without hitting them.
    void ignore_passed(std::uint64_t lanes, const std::uint32_t (&surface)[W], const std::uint32_t (&primitive)[W]) {
        for (const int i : lanes_in(lanes)) {
            passed_surface_[i] = surface[i];
            passed_primitive_[i] = primitive[i];
        }
        has_passed_ |= lanes;
    }

    /// Called after steps of `lanes` that were not queried: their next segment does not start on a surface.
    void leave_surfaces(std::uint64_t lanes) { may_start_on_surface_ &= ~lanes; }

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
                            near_start = may_start_on_surface | passed | (open & departing_);
        may_start_on_surface_ &= ~open;
        departing_ &= ~open;
        has_passed_ &= ~open;
        Segments<W> segments;
        V begin(S(0)), length(S(1));  // start and length of the queried segment, as fractions of the chord
        if (near_start) {
            begin = select(from_bits<V>(near_start), -start_extension(b - a), begin);
            length = V(S(1)) - begin;
        }
        const Vec3<V> query_start = near_start ? advance(a, begin, b - a) : a;
        const V scale(S(geometry_.scale));
        V size(S(0));  // greatest absolute coordinate of both ends, in Embree's coordinates
        const auto to_embree = [&](const V& start, const V& end, int k) {
            const V shift(S(geometry_.shift[k])), embree_start = (start - shift) * scale,
                    embree_end = (end - shift) * scale;
            size = max(size, max(abs(embree_start), abs(embree_end)));
            to_floats(embree_start, segments.org[k]);
            to_floats((end - start) * scale, segments.dir[k]);
        };
        to_embree(query_start.x, b.x, 0);
        to_embree(query_start.y, b.y, 1);
        to_embree(query_start.z, b.z, 2);
        std::fill_n(segments.near, W, 0.0f);
        std::fill_n(segments.t, W, 0.0f);
        if (geometry_.has_spheres) {
            const Vec3<V> whole = b - query_start;
            to_doubles(query_start.x, segments.exact_org[0]);
            to_doubles(query_start.y, segments.exact_org[1]);
            to_doubles(query_start.z, segments.exact_org[2]);
            to_doubles(whole.x, segments.exact_dir[0]);
            to_doubles(whole.y, segments.exact_dir[1]);
            to_doubles(whole.z, segments.exact_dir[2]);
            const double greatest = greatest_margin / geometry_.scale;
            segments.margin = exact || chord_only_ ? 0 : std::min(task_.job.chord_tolerance, greatest);
            for (int i = 0; i < W; ++i) segments.ignored[i] = (passed >> i) & 1 ? passed_surface_[i] : no_surface;
        }
        skip_outside_escape_sphere(query_start, b, segments);
        for (const int i : lanes_in(open & ~to_bits(size < V(S(clip_size))))) {
            if (!clip(a, b, i, segments, begin, length)) open &= ~(std::uint64_t(1) << i);
        }
        queries_ = select(from_bits<V>(open), queries_ + V(S(1)), queries_);
        std::uint64_t hit = kagero::query(geometry_.embree_scene, segments, open);
        if (hit & near_start)
            hit = remove_departed_surfaces(a, b, begin, length, segments, hit, hit & near_start, may_start_on_surface,
                                           passed);
        if constexpr (exact) hit = confirm(a, b, begin, length, segments, hit, near_start, may_start_on_surface);
        if (!hit) return 0;
        const MaskOf<V> mask = from_bits<V>(hit);
        hits.t = select(mask, fractions_of(segments, begin, length), hits.t);
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
    /// Returns the length, as a fraction of the chord, by which a query begins before the start of a piece. Without it,
    /// Embree could miss surfaces close to the start because of its rounding in float.
    V start_extension(const Vec3<V>& chord) const {
        const V offset(S(double(start_offset) / geometry_.scale));
        return offset / max(fast_sqrt(dot(chord, chord)), offset);
    }
    /// Converts the positions t on the queried segments to fractions of the chords a → b.
    static V fractions_of(const Segments<W>& segments, const V& begin, const V& length) {
        alignas(64) double fraction[W];
        std::copy_n(segments.t, W, fraction);
        return fma(length, lanes_of<V>(fraction), begin);
    }

    /// Removes the hits of surfaces from which rays depart, since Embree's floats cannot show on which side of a close
    /// surface a ray starts. Such lanes are queried again, and each candidate hit is tested in double precision.
    /// Returns the lanes of `hit` that still hit a surface. The segments of the lanes `close` may start close to a
    /// surface, and those of the lanes `may_start_on_surface` may start on one.
    std::uint64_t remove_departed_surfaces(const Vec3<V>& a, const Vec3<V>& b, const V& begin, const V& length,
                                           Segments<W>& segments, std::uint64_t hit, std::uint64_t close,
                                           std::uint64_t may_start_on_surface, std::uint64_t passed) {
        const V least = start_extension(b - a);
        const LevelSet<V> level_sets =
            level_sets_of<V>(geometry_.surfaces, segments.surface, segments.primitive, close);
        const V fraction = chord_fraction(level_sets, a, b, fractions_of(segments, begin, length));
        std::uint64_t departed =
            close & to_bits(departs(level_sets, a, b, fraction, least, from_bits<V>(may_start_on_surface)));
        for (const int i : lanes_in(passed & hit))
            if (has_passed(i, segments.surface[i], segments.primitive[i])) departed |= std::uint64_t(1) << i;
        if (!departed) return hit;
        departing_ |= departed;
        const auto accepts = [&](int i, std::uint32_t surface, std::uint32_t primitive, float t) {
            if (((passed >> i) & 1) != 0 && has_passed(i, surface, primitive)) return false;
            const double near = double(get_lane(length, i)) * double(t) + double(get_lane(begin, i));
            const LevelSet<double> level_set = level_set_of(geometry_.surfaces[surface], primitive);
            const Vec3<double> from = lane_of(a, i), to = lane_of(b, i);
            return !departs(level_set, from, to, chord_fraction(level_set, from, to, near), double(get_lane(least, i)),
                            ((may_start_on_surface >> i) & 1) != 0);
        };
        return (hit & ~departed) | query_filtered(geometry_.embree_scene, segments, departed, accepts);
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
        const V least = start_extension(b - a);
        const auto accepts = [&](int i, std::uint32_t surface, std::uint32_t primitive, float t) {
            const double near = double(get_lane(length, i)) * double(t) + double(get_lane(begin, i));
            const Surface& candidate = geometry_.surfaces[surface];
            const LevelSet<double> level_set = level_set_of(candidate, primitive);
            const Vec3<double> from = lane_of(a, i), to = lane_of(b, i);
            const double at = chord_fraction(level_set, from, to, near);
            if (((near_start >> i) & 1) != 0 &&
                departs(level_set, from, to, at, double(get_lane(least, i)), ((may_start_on_surface >> i) & 1) != 0))
                return false;
            if (candidate.kind == Surface::Kind::sphere) return true;
            const Vec3<double> x = advance(from, at, to - from);
            const double greatest = std::max({std::abs(x.x), std::abs(x.y), std::abs(x.z), size});
            return bool(triangle_of(candidate, primitive)
                            .contains_line(x, to - from, 4 * double(machine_epsilon<S>) * greatest));
        };
        return confirmed | query_filtered(geometry_.embree_scene, segments, hit & ~confirmed, accepts);
    }

    /// Returns true if the ray of a lane has just passed this triangle.
    bool has_passed(int lane, std::uint32_t surface, std::uint32_t primitive) const {
        return surface == passed_surface_[lane] && primitive == passed_primitive_[lane] &&
               geometry_.surfaces[surface].kind == Surface::Kind::triangles;
    }

    /// Returns true if no ray starts on a surface: the distance of the camera from every surface is large compared with
    /// the rounding of Embree's floats and of the packet's number type.
    bool starts_off_surfaces() const {
        const CameraRays* camera = task_.job.camera;
        if (!camera) return false;
        const double* q = camera->position;
        const double size = std::max({std::abs(q[0]), std::abs(q[1]), std::abs(q[2])}) + 1 / geometry_.scale;
        return camera->clearance > 2 * double(start_offset) / geometry_.scale + 16 * double(machine_epsilon<S>) * size;
    }

    /// Returns the lanes in which a → b departs from the surface that the query has found at `fraction`, rather than
    /// hitting it. Such a segment starts on the surface or moves away from it. A segment that starts on a sphere
    /// departs from it only if the segment does not meet the sphere again beyond the fraction `least`. In lanes of
    /// `may_start_on_surface`, a start within rounding of the surface counts as a start on the surface.
    template <class T>
    MaskOf<T> departs(const LevelSet<T>& g, const Vec3<T>& a, const Vec3<T>& b, const T& fraction, const T& least,
                      const MaskOf<T>& may_start_on_surface) const {
        const T zero(0), height = g.value(a),
                         size = max(max(abs(a.x), abs(a.y)), abs(a.z)) + T(ScalarOf<T>(1 / geometry_.scale));
        const T rounding = T(ScalarOf<T>(4 * machine_epsilon<S>)) * size;
        const MaskOf<T> on_surface = may_start_on_surface & (abs(height) <= rounding);
        const T away = height * g.slope(a, b - a);
        const MaskOf<T> from_plane = on_surface | (away >= zero),
                        from_sphere = (fraction <= zero) | (on_surface & (fraction <= least));
        return ((abs(g.a) <= zero) & from_plane) | ((abs(g.a) > zero) & from_sphere);
    }

    /// For segments that begin outside the escape sphere, moves the start of the query to their entry into the sphere.
    void skip_outside_escape_sphere(const Vec3<V>& a, const Vec3<V>& b, Segments<W>& segments) const {
        const S radius = S(task_.job.escape_radius);
        const MaskOf<V> beyond = dot(a, a) > V(radius * radius);
        if (!any(beyond)) return;
        const V entry = chord_fraction(sphere_level_set(V(radius)), a, b, V(S(0)));
        float entries[W];
        to_floats(select(beyond & (entry > V(S(0))) & (entry < V(S(1))), entry, V(S(0))), entries);
        for (int i = 0; i < W; ++i) segments.near[i] = std::max(segments.near[i], entries[i]);
    }

    /// Clips the queried part of a → b in lane i to the cube of edge `clip_size` around the origin of Embree's
    /// coordinates, in double precision. Returns false if the segment misses the cube.
    bool clip(const Vec3<V>& a, const Vec3<V>& b, int i, Segments<W>& segments, V& begin, V& length) const {
        const double start[3] = {double(get_lane(a.x, i)), double(get_lane(a.y, i)), double(get_lane(a.z, i))};
        const double end[3] = {double(get_lane(b.x, i)), double(get_lane(b.y, i)), double(get_lane(b.z, i))};
        const double old_begin = double(get_lane(begin, i)),
                     near = old_begin + double(get_lane(length, i)) * double(segments.near[i]);
        double enter = old_begin, leave = 1, org[3], dir[3];
        for (int k = 0; k < 3; ++k) {
            org[k] = (start[k] - geometry_.shift[k]) * geometry_.scale;
            dir[k] = (end[k] - start[k]) * geometry_.scale;
            const double half = 0.5 * double(clip_size), u = (-half - org[k]) / dir[k], v = (half - org[k]) / dir[k];
            if (dir[k] == 0 && std::abs(org[k]) > half) return false;
            if (dir[k] != 0) {
                enter = std::max(enter, std::min(u, v));
                leave = std::min(leave, std::max(u, v));
            }
        }
        if (!(enter < leave)) return false;
        const double clipped_length = leave - enter;
        set_lane(begin, i, S(enter));
        set_lane(length, i, S(clipped_length));
        segments.near[i] = float(std::clamp((near - enter) / clipped_length, 0.0, 1.0));
        if (geometry_.has_spheres)
            for (int k = 0; k < 3; ++k) {
                segments.exact_org[k][i] = start[k] + enter * (end[k] - start[k]);
                segments.exact_dir[k][i] = clipped_length * (end[k] - start[k]);
            }
        for (int k = 0; k < 3; ++k) {
            segments.org[k][i] = float(org[k] + enter * dir[k]);
            segments.dir[k][i] = float(clipped_length * dir[k]);
        }
        return true;
    }

    /// Distance from a surface below which floats do not distinguish its sides, in Embree's coordinates. It is about 30
    /// rounding errors of a coordinate of order one.
    static constexpr float start_offset = 4e-6f;
    /// In Embree's coordinates: a segment with an absolute coordinate of at least this value is clipped before a query,
    /// to the cube with this edge around the origin.
    static constexpr float clip_size = 8;

    const Task<V>& task_;
    const Geometry& geometry_;
    bool chord_only_;           ///< True if each step is intersected as its chord.
    bool starts_off_surfaces_;  ///< True if no ray starts on a surface.
    V queries_ = S(0);
    /// Lanes whose next segment may start on a surface: the first segment of a ray, or the first one after an event
    /// that has changed the state of the ray.
    std::uint64_t may_start_on_surface_ = 0;
    std::uint64_t has_passed_ = 0;  ///< Lanes whose ray has just passed a primitive, which the next query ignores.
    std::uint32_t passed_surface_[W], passed_primitive_[W];
    std::uint64_t departing_ = 0;           ///< Lanes whose previous piece has departed from a close surface.
};

}  // namespace kagero
