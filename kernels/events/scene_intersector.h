/// Intersects steps with the scene: which lanes hit which surface, and roughly where on the step.
///
/// Most steps need no query: a lane knows a box without a surface around its ray, from the clearance grid. Where a step
/// leads out of such boxes, its dense output is cut into chords that stay within the tolerance, and Embree intersects
/// them.
#pragma once

#include "kernels/intersection/clearance.h"
#include "kernels/intersection/segment_query.h"
#include "kernels/intersection/stopwatch.h"
#include "kernels/intersection/surface.h"
#include "kernels/methods/task.h"

#include <algorithm>
#include <cmath>

namespace kagero {

template <class V>
Vec3<double> lane_of(const Vec3<V>& v, int i) {
    return {double(get_lane(v.x, i)), double(get_lane(v.y, i)), double(get_lane(v.z, i))};
}

/// What the lanes of a packet have hit.
template <class V>
struct SurfaceHits {
    std::uint32_t surface[lane_count<V>] = {}, primitive[lane_count<V>] = {};
    V from{ScalarOf<V>(0)}, to{ScalarOf<V>(0)};  ///< the piece of the step that was hit, as fractions of the step
    V t{ScalarOf<V>(0)};                         ///< where on the chord of that piece, from Embree

    /// Roughly where on the step, as a fraction.
    V hit_fraction() const { return fma(t, to - from, from); }
};

template <class V>
class SceneIntersector {
    using S = ScalarOf<V>;
    static constexpr int W = lane_count<V>;

public:
    SurfaceHits<V> hits;      ///< valid in lanes that the last query has hit
    std::uint64_t ticks = 0;  ///< time of queries, where the job is timed

    explicit SceneIntersector(const Task<V>& task)
        : task_(task), geometry_(*task.job.geometry), tolerance_(S(task.job.chord_tolerance)),
          chord_only_(task.job.hit == HitModel::chord), starts_in_the_open_(starts_in_the_open()) {}

    /// New rays start in `lanes`: a surface on which a ray starts does not count as hit.
    void begin(std::uint64_t lanes) {
        queries_ = select(from_bits<V>(lanes), V(S(0)), queries_);
        leaving_ &= ~lanes;
        return_to_start(lanes);
    }
    /// The rays of `lanes` are at their start again.
    void return_to_start(std::uint64_t lanes) {
        if (!starts_in_the_open_) first_piece_ |= lanes;
    }

    /// Intersects the step of `lanes` and returns the lanes that hit a surface. Lanes whose step bends more than chords
    /// can follow are not tested and are removed from `lanes`.
    std::uint64_t intersect(const StepperState<V>& step, std::uint64_t& lanes) {
        const std::uint64_t leading_out =
            geometry_.clearance ? lanes & ~to_bits(clear_.holds(task_.extent(step))) : lanes;
        const std::uint64_t hit = leading_out ? intersect_outside(step, leading_out, lanes) : 0;
        first_piece_ &= ~lanes;
        return hit;
    }
    /// Intersects straight segments of any length with one query.
    std::uint64_t intersect_straight(const Vec3<V>& start, const Vec3<V>& end, std::uint64_t lanes) {
        const Stopwatch watch(task_.job.timed, ticks);
        return query_piece(start, end, V(S(0)), V(S(1)), lanes);
    }

    /// The surfaces that `lanes` have hit.
    Level<V> levels(std::uint64_t lanes) const {
        return levels_of<V>(geometry_.surfaces, hits.surface, hits.primitive, lanes);
    }
    /// Queries of each ray.
    const V& queries() const { return queries_; }

private:
    /// The steps of `lanes` lead out of the box that is known to be clear. The box around the middle of the step may
    /// contain all of it; if not, Embree is queried. A box is a part of space and stays clear, whatever happens to the
    /// ray of its lane.
    __attribute__((noinline)) std::uint64_t intersect_outside(const StepperState<V>& step, std::uint64_t lanes,
                                                              std::uint64_t& tested) {
        const Curve<V> curve = task_.curve(step);
        if (geometry_.clearance && clear_.move(*geometry_.clearance, curve.middle(), lanes))
            lanes &= ~to_bits(clear_.holds(curve.extent()));
        if (!lanes) return 0;
        const Stopwatch watch(task_.job.timed, ticks);
        const V sagitta = chord_only_ ? V(S(0)) : curve.sagitta();
        const std::uint64_t too_bent = lanes & to_bits(sagitta > V(tolerance_ * S(most_pieces) * S(most_pieces)));
        tested &= ~too_bent;
        return query_pieces(curve, length_of_pieces(sagitta), lanes & ~too_bent);
    }

    /// Cuts the step into pieces, each lane into its own number of them, and queries the pieces that no clear box
    /// contains. Lanes meet at such pieces, so that one query serves many lanes.
    std::uint64_t query_pieces(const Curve<V>& curve, const V& piece, std::uint64_t lanes) {
        const V one(S(1)), half(S(0.5));
        const std::uint64_t cut =
            geometry_.clearance ? lanes & to_bits(piece < one) : 0;  // a whole step is not clear, as is known
        const Extent<V> times = cut ? least_times(curve.speeds()) : Extent<V>{};
        std::uint64_t hit = 0, now = lanes;
        V s0(S(0));
        while (now) {
            for (std::uint64_t going = now & cut; going;) {
                const Vec3<V> here = curve.at(s0);
                V clear = clear_.way_out(here, times);
                if (const std::uint64_t at_the_edge = going & ~to_bits(clear >= piece)) {
                    if (clear_.move(*geometry_.clearance, curve.at(fma(half, piece, s0)), at_the_edge))
                        clear = clear_.way_out(here, times);
                }
                const MaskOf<V> passes = from_bits<V>(going) & (clear >= piece);
                s0 = select(passes, min(s0 + whole_pieces(clear, piece), one), s0);
                const std::uint64_t ended = to_bits(passes & (s0 >= one));
                going = to_bits(passes) & ~ended, now &= ~ended;
            }
            if (!now) break;
            const V s1 = min(s0 + piece, one);
            hit |= query_piece(curve.at(s0), curve.at(s1), s0, s1, now);
            now &= ~(hit | to_bits(s1 >= one));
            s0 = s1;
        }
        return hit;
    }

    /// Queries the segments a → b, which are the pieces [s0, s1] of the steps of lanes `now`.
    std::uint64_t query_piece(const Vec3<V>& a, const Vec3<V>& b, const V& s0, const V& s1, std::uint64_t now) {
        const std::uint64_t first = now & first_piece_, near_start = first | (now & leaving_);
        first_piece_ &= ~now, leaving_ &= ~now;
        Segments<W> segments;
        V begin(S(0)), length(S(1));  // the part of each piece that is queried, as fractions of the piece
        if (near_start) {
            begin = select(from_bits<V>(near_start), -head_start(b - a), begin);
            length = V(S(1)) - begin;
        }
        const Vec3<V> from = near_start ? advance(a, begin, b - a) : a;
        const V scale(S(geometry_.scale));
        V size(S(0));  // the greatest coordinate of either end
        const auto to_embree = [&](const V& start, const V& end, int k) {
            const V shift(S(geometry_.shift[k])), from_here = (start - shift) * scale, to_here = (end - shift) * scale;
            size = max(size, max(abs(from_here), abs(to_here)));
            to_floats(from_here, segments.org[k]);
            to_floats((end - start) * scale, segments.dir[k]);
        };
        to_embree(from.x, b.x, 0), to_embree(from.y, b.y, 1), to_embree(from.z, b.z, 2);
        std::fill_n(segments.near, W, 0.0f), std::fill_n(segments.t, W, 0.0f);
        skip_outside(from, b, segments);
        for (const int i : lanes_in(now & ~to_bits(size < V(S(far_away))))) {
            if (!clip(a, b, i, segments, begin, length)) now &= ~(std::uint64_t(1) << i);
        }
        queries_ = select(from_bits<V>(now), queries_ + V(S(1)), queries_);
        std::uint64_t hit = query(geometry_.embree_scene, segments, now);
        if (hit & near_start) hit = without_left_surfaces(a, b, begin, length, segments, hit, hit & near_start, first);
        if (!hit) return 0;
        const MaskOf<V> here = from_bits<V>(hit);
        hits.t = select(here, fractions_of(segments, begin, length), hits.t);
        hits.from = select(here, s0, hits.from), hits.to = select(here, s1, hits.to);
        for (int i = 0; i < W; ++i) {
            const bool is_hit = (hit >> i) & 1;
            hits.surface[i] = is_hit ? segments.surface[i] : hits.surface[i];
            hits.primitive[i] = is_hit ? segments.primitive[i] : hits.primitive[i];
        }
        return hit;
    }

    /// A piece is queried from a little before its start, this fraction of it, so that Embree's floats miss no surface
    /// close to the start.
    V head_start(const Vec3<V>& way) const {
        const V offset(S(double(start_offset) / geometry_.scale));
        return offset / max(root(dot(way, way)), offset);
    }
    static V fractions_of(const Segments<W>& segments, const V& begin, const V& length) {
        alignas(64) double fraction[W];
        std::copy_n(segments.t, W, fraction);
        return fma(length, lanes_of<V>(fraction), begin);
    }

    /// Removes hits of surfaces that rays leave: so close to a surface, Embree's floats do not show on which side of it
    /// a ray is. `close` are the lanes that are close to their start, `first` those in the first piece of their ray.
    /// They are queried again, surface by surface.
    std::uint64_t without_left_surfaces(const Vec3<V>& a, const Vec3<V>& b, const V& begin, const V& length,
                                        Segments<W>& segments, std::uint64_t hit, std::uint64_t close,
                                        std::uint64_t first) {
        const V least = head_start(b - a);
        const Level<V> levels = levels_of<V>(geometry_.surfaces, segments.surface, segments.primitive, close);
        const V fraction = chord_fraction(levels, a, b, fractions_of(segments, begin, length));
        const std::uint64_t left = close & to_bits(leaves(levels, a, b, fraction, least, from_bits<V>(first)));
        if (!left) return hit;
        leaving_ |= left;
        const auto is_hit = [&](int i, std::uint32_t on, std::uint32_t part, float where) {
            const double near = double(get_lane(length, i)) * double(where) + double(get_lane(begin, i));
            const Level<double> level = level_of(geometry_.surfaces[on], part);
            const Vec3<double> from = lane_of(a, i), to = lane_of(b, i);
            return !leaves(level, from, to, chord_fraction(level, from, to, near), double(get_lane(least, i)),
                           ((first >> i) & 1) != 0);
        };
        return (hit & ~left) | query_carefully(geometry_.embree_scene, segments, left, is_hit);
    }
    /// Whether all rays start so far from every surface that they leave none: farther than the errors of Embree's
    /// floats and of the packet's own numbers.
    bool starts_in_the_open() const {
        const CameraRays* camera = task_.job.camera;
        if (!camera) return false;
        const double* q = camera->position;
        const double size = std::max({std::abs(q[0]), std::abs(q[1]), std::abs(q[2])}) + 1 / geometry_.scale;
        return camera->clear > 2 * double(start_offset) / geometry_.scale + 16 * double(machine_epsilon<S>) * size;
    }

    /// Whether a → b leaves a surface that it seems to hit at `fraction`: it starts on the surface or goes away from
    /// it. A sphere is only left by a ray that does not hit it again beyond the fraction `least`. Where
    /// `may_start_there`, a start within rounding is on the surface.
    template <class W2>
    MaskOf<W2> leaves(const Level<W2>& g, const Vec3<W2>& a, const Vec3<W2>& b, const W2& fraction, const W2& least,
                      const MaskOf<W2>& may_start_there) const {
        const W2 zero(0), height = g.value(a),
                          size = max(max(abs(a.x), abs(a.y)), abs(a.z)) + W2(ScalarOf<W2>(1 / geometry_.scale));
        const MaskOf<W2> on_it = may_start_there & (abs(height) <= W2(ScalarOf<W2>(4 * machine_epsilon<S>)) * size);
        const W2 away = height * g.slope(a, b - a);
        const MaskOf<W2> from_plane = on_it | (away >= zero),
                         from_sphere = (fraction <= zero) | (on_it & (fraction <= least));
        return ((abs(g.a) <= zero) & from_plane) | ((abs(g.a) > zero) & from_sphere);
    }

    /// A segment that comes from outside hits nothing before it enters the escape sphere.
    void skip_outside(const Vec3<V>& a, const Vec3<V>& b, Segments<W>& segments) const {
        const S radius = S(task_.job.escape_radius);
        const MaskOf<V> beyond = dot(a, a) > V(radius * radius);
        if (!any(beyond)) return;
        const V entry = chord_fraction(sphere_level(V(radius)), a, b, V(S(0)));
        float entries[W];
        to_floats(select(beyond & (entry > V(S(0))) & (entry < V(S(1))), entry, V(S(0))), entries);
        for (int i = 0; i < W; ++i) segments.near[i] = std::max(segments.near[i], entries[i]);
    }

    /// Clips the queried part of a → b, in double, to the cube ±far_away/2 around the scene; false if it misses the
    /// cube.
    bool clip(const Vec3<V>& a, const Vec3<V>& b, int i, Segments<W>& segments, V& begin, V& length) const {
        const double head[3] = {double(get_lane(a.x, i)), double(get_lane(a.y, i)), double(get_lane(a.z, i))};
        const double tail[3] = {double(get_lane(b.x, i)), double(get_lane(b.y, i)), double(get_lane(b.z, i))};
        const double first = double(get_lane(begin, i)),
                     nearest = first + double(get_lane(length, i)) * double(segments.near[i]);
        double enter = first, leave = 1, org[3], dir[3];
        for (int k = 0; k < 3; ++k) {
            org[k] = (head[k] - geometry_.shift[k]) * geometry_.scale, dir[k] = (tail[k] - head[k]) * geometry_.scale;
            const double half = 0.5 * double(far_away), u = (-half - org[k]) / dir[k], v = (half - org[k]) / dir[k];
            if (dir[k] == 0 && std::abs(org[k]) > half) return false;
            if (dir[k] != 0) enter = std::max(enter, std::min(u, v)), leave = std::min(leave, std::max(u, v));
        }
        if (!(enter < leave)) return false;
        const double rest = leave - enter;
        set_lane(begin, i, S(enter)), set_lane(length, i, S(rest));
        segments.near[i] = float(std::clamp((nearest - enter) / rest, 0.0, 1.0));
        for (int k = 0; k < 3; ++k)
            segments.org[k][i] = float(org[k] + enter * dir[k]), segments.dir[k][i] = float(rest * dir[k]);
        return true;
    }

    /// The length of pieces as fractions of the step.
    V length_of_pieces(V sagitta) const {
        V length(S(1));
        for (int pieces = 1; pieces < most_pieces; pieces *= 2) {
            const MaskOf<V> bent = sagitta > V(tolerance_);
            if (!any(bent)) break;
            length = select(bent, V(S(0.5)) * length, length);
            sagitta = V(S(0.25)) * sagitta;
        }
        return length;
    }
    /// The length of as many whole pieces as fit.
    static V whole_pieces(const V& way, const V& piece) {
        const V fit = min(way / piece, V(S(most_pieces))), nearest = nearest_whole(fit);
        return select(nearest > fit, nearest - V(S(1)), nearest) * piece;
    }
    static constexpr int most_pieces = 1024;
    /// So close to a surface, floats do not distinguish its sides: some 30 roundings, in Embree's coordinates of order
    /// one.
    static constexpr float start_offset = 4e-6f;
    /// Segments that reach farther are clipped to the scene first, in the same coordinates.
    static constexpr float far_away = 32;

    const Task<V>& task_;
    const Geometry& geometry_;
    S tolerance_;
    bool chord_only_, starts_in_the_open_;
    ClearBox<V> clear_ = task_.first_box;
    V queries_ = S(0);
    std::uint64_t first_piece_ = 0;  ///< lanes of which no piece has been queried
    std::uint64_t leaving_ = 0;      ///< lanes that left a surface in the piece before, and were too close to it
};

}  // namespace kagero
