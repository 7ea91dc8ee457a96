/// The step just taken against the scene: which lanes hit what, and roughly where on the step.
///
/// Most steps ask nothing: each lane knows of a box in which there is no surface, from the clearance grid. Where a step leads out of
/// such boxes the dense output is cut into chords that stay within the tolerance and Embree is asked.
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

template <class V>
class Encounter {
    using S = ScalarOf<V>;
    static constexpr int W = lane_count<V>;

public:
    /// What each hit lane met.
    std::uint32_t surface[W] = {}, primitive[W] = {};
    V from = S(0), to = S(0);  ///< the piece of the step that was hit, as fractions
    V t = S(0);                ///< where on that piece's chord, from Embree
    std::uint64_t ticks = 0;

    explicit Encounter(const Task<V>& task) : task_(task), geometry_(*task.job.geometry), tolerance_(S(task.job.chord_tolerance)),
                                              chord_only_(task.job.hit == HitModel::chord), timed_(task.job.timed),
                                              in_the_open_(starts_in_the_open()) {}

    /// New ray in the lanes of `lanes`: the surface it stands on does not count.
    void begin(std::uint64_t lanes) {
        queries_ = pick(from_bits<V>(lanes), V(S(0)), queries_);
        leaving_ &= ~lanes;
        start_again(lanes);
    }

    /// Tests the step in `flow` for the lanes of `active`; returns those that hit. Lanes whose step bends by more than chords can follow are
    /// left out, and out of `active`.
    std::uint64_t meet(const Flow<V>& flow, std::uint64_t& active) {
        const std::uint64_t leading_out = geometry_.clearance ? active & ~to_bits(clear_.holds(task_.extent(flow))) : active;
        const std::uint64_t hits = leading_out ? meet_outside(flow, leading_out, active) : 0;
        fresh_ &= ~active;
        return hits;
    }

    /// Where on their step lanes hit something, about: as fractions.
    V place() const { return mul_add(t, to - from, from); }
    /// Lanes go back to where their ray began.
    void start_again(std::uint64_t lanes) {
        if (!in_the_open_) fresh_ |= lanes;
    }

    /// What the lanes of `hits` met.
    Level<V> levels(std::uint64_t hits) const { return levels_of<V>(geometry_.surfaces, surface, primitive, hits); }
    /// As `meet`, for a straight way, however long: one query, as no clearance is of use to it.
    std::uint64_t meet_straight(const Vec3<V>& start, const Vec3<V>& end, std::uint64_t active) {
        const Stopwatch watch(timed_, ticks);
        return ask_piece(start, end, V(S(0)), V(S(1)), active);
    }

    /// How often the rays have been asked about.
    const V& queries() const { return queries_; }

private:
    /// Lanes whose step leads out of the box that is known to be clear: another is looked for in the middle of the step, and where that does
    /// not hold the step either, Embree is asked. A box is a part of space, and so stays clear whatever becomes of its lane's ray.
    __attribute__((noinline)) std::uint64_t meet_outside(const Flow<V>& flow, std::uint64_t lanes, std::uint64_t& active) {
        const Curve<V> curve = task_.curve(flow);
        if (geometry_.clearance && clear_.move(*geometry_.clearance, curve.middle(), lanes)) lanes &= ~to_bits(clear_.holds(curve.extent()));
        if (!lanes) return 0;
        const Stopwatch watch(timed_, ticks);
        const V sagitta = chord_only_ ? V(S(0)) : curve.sagitta();
        const std::uint64_t too_bent = lanes & to_bits(sagitta > V(tolerance_ * S(most_pieces) * S(most_pieces)));
        active &= ~too_bent;
        return ask(curve, length_of_pieces(sagitta), lanes & ~too_bent);
    }

    /// Cuts the step into pieces, each lane its own number of them, and queries those that no clear box holds. Lanes
    /// wait for each other at such pieces, so that one query serves many.
    std::uint64_t ask(const Curve<V>& curve, const V& piece, std::uint64_t asking) {
        const V one(S(1)), half(S(0.5));
        const std::uint64_t cut = geometry_.clearance ? asking & to_bits(piece < one) : 0;  // a whole step was told to ask
        const Extent<V> times = cut ? least_times(curve.speeds()) : Extent<V>{};
        std::uint64_t hits = 0, now = asking;
        V s0(S(0));
        while (now) {
            for (std::uint64_t going = now & cut; going;) {
                const Vec3<V> here = curve.at(s0);
                V clear = clear_.way_out(here, times);
                if (const std::uint64_t at_the_edge = going & ~to_bits(clear >= piece)) {
                    if (clear_.move(*geometry_.clearance, curve.at(mul_add(half, piece, s0)), at_the_edge)) clear = clear_.way_out(here, times);
                }
                const MaskOf<V> passes = from_bits<V>(going) & (clear >= piece);
                s0 = pick(passes, min(s0 + whole_pieces(clear, piece), one), s0);
                const std::uint64_t ended = to_bits(passes & (s0 >= one));
                going = to_bits(passes) & ~ended, now &= ~ended;
            }
            if (!now) break;
            const V s1 = min(s0 + piece, one);
            hits |= ask_piece(curve.at(s0), curve.at(s1), s0, s1, now);
            now &= ~(hits | to_bits(s1 >= one));
            s0 = s1;
        }
        return hits;
    }

    std::uint64_t ask_piece(const Vec3<V>& a, const Vec3<V>& b, const V& s0, const V& s1, std::uint64_t now) {
        const std::uint64_t first = now & fresh_, near_start = first | (now & leaving_);
        fresh_ &= ~now, leaving_ &= ~now;
        Segments<W> segments;
        V begin(S(0)), length(S(1));  // the part of each piece that is asked about, as fractions of the piece
        if (near_start) {
            begin = pick(from_bits<V>(near_start), -head_start(b - a), begin);
            length = V(S(1)) - begin;
        }
        const Vec3<V> from_where = near_start ? advance(a, begin, b - a) : a;
        const V scale(S(geometry_.scale));
        V size(S(0));  // of the greatest coordinate of either end
        const auto to_embree = [&](const V& start, const V& end, int k) {
            const V shift(S(geometry_.shift[k])), from_here = (start - shift) * scale, to_here = (end - shift) * scale;
            size = max(size, max(abs(from_here), abs(to_here)));
            to_floats(from_here, segments.org[k]);
            to_floats((end - start) * scale, segments.dir[k]);
        };
        to_embree(from_where.x, b.x, 0), to_embree(from_where.y, b.y, 1), to_embree(from_where.z, b.z, 2);
        std::fill_n(segments.near, W, 0.0f), std::fill_n(segments.t, W, 0.0f);
        skip_what_lies_beyond(from_where, b, segments);
        for (const int i : lanes_in(now & ~to_bits(size < V(S(far_away))))) {
            if (!clip(a, b, i, segments, begin, length)) now &= ~(std::uint64_t(1) << i);
        }
        queries_ = pick(from_bits<V>(now), queries_ + V(S(1)), queries_);
        std::uint64_t hits = query(geometry_.embree_scene, segments, now);
        if (hits & near_start) hits = without_what_is_left(a, b, begin, length, segments, hits, hits & near_start, first);
        if (!hits) return 0;
        const MaskOf<V> here = from_bits<V>(hits);
        t = pick(here, places_of(segments, begin, length), t);
        from = pick(here, s0, from), to = pick(here, s1, to);
        for (int i = 0; i < W; ++i) {
            const bool hit = (hits >> i) & 1;
            surface[i] = hit ? segments.surface[i] : surface[i], primitive[i] = hit ? segments.primitive[i] : primitive[i];
        }
        return hits;
    }

    /// How far before its start a piece is looked at, as a fraction of it, so that Embree's floats pass over no surface close to the start.
    V head_start(const Vec3<V>& way) const {
        const V offset(S(double(start_offset) / geometry_.scale));
        return offset / max(root(dot(way, way)), offset);
    }
    static V places_of(const Segments<W>& segments, const V& begin, const V& length) {
        alignas(64) double place[W];
        std::copy_n(segments.t, W, place);
        return mul_add(length, lanes_of<V>(place), begin);
    }

    /// Of the rays of `close` to their start, some of them in their `first` piece, the hits of what they leave do not count: Embree's floats do
    /// not tell on which side of a surface they are so close to it. Those rays are asked again, with an eye to each surface.
    std::uint64_t without_what_is_left(const Vec3<V>& a, const Vec3<V>& b, const V& begin, const V& length, Segments<W>& segments,
                                       std::uint64_t hits, std::uint64_t close, std::uint64_t first) {
        const V least = head_start(b - a);
        const Level<V> levels = levels_of<V>(geometry_.surfaces, segments.surface, segments.primitive, close);
        const V place = chord_fraction(levels, a, b, places_of(segments, begin, length));
        const std::uint64_t left = close & to_bits(leaves(levels, a, b, place, least, from_bits<V>(first)));
        if (!left) return hits;
        leaving_ |= left;
        const auto meets = [&](int i, std::uint32_t on, std::uint32_t part, float where) {
            const double near = double(get_lane(length, i)) * double(where) + double(get_lane(begin, i));
            const Level<double> level = level_of(geometry_.surfaces[on], part);
            const Vec3<double> from_here = lane_of(a, i), to_here = lane_of(b, i);
            return !leaves(level, from_here, to_here, chord_fraction(level, from_here, to_here, near), double(get_lane(least, i)), ((first >> i) & 1) != 0);
        };
        return (hits & ~left) | query_carefully(geometry_.embree_scene, segments, left, meets);
    }
    /// Whether rays start so far from every surface that none is left: farther than Embree's floats and the packet's own numbers may err.
    bool starts_in_the_open() const {
        const CameraRays* camera = task_.job.camera;
        if (!camera) return false;
        const double* q = camera->position;
        const double size = std::max({std::abs(q[0]), std::abs(q[1]), std::abs(q[2])}) + 1 / geometry_.scale;
        return camera->clear > 2 * double(start_offset) / geometry_.scale + 16 * double(machine_epsilon<S>) * size;
    }

    /// Whether a → b leaves a surface that it seems to meet at `place`: it starts on it, or goes away from it; of a sphere, to where it meets that
    /// again beyond the fraction `least`. Only where it `may_start_there` a start within roundings counts as one on the surface.
    template <class W2>
    MaskOf<W2> leaves(const Level<W2>& g, const Vec3<W2>& a, const Vec3<W2>& b, const W2& place, const W2& least,
                      const MaskOf<W2>& may_start_there) const {
        const W2 zero(0), height = g.value(a), size = max(max(abs(a.x), abs(a.y)), abs(a.z)) + W2(ScalarOf<W2>(1 / geometry_.scale));
        const MaskOf<W2> on_it = may_start_there & (abs(height) <= W2(ScalarOf<W2>(4 * machine_epsilon<S>)) * size);
        const W2 away = height * g.slope(a, b - a);
        const MaskOf<W2> from_plane = on_it | (away >= zero), from_sphere = (place <= zero) | (on_it & (place <= least));
        return ((abs(g.a) <= zero) & from_plane) | ((abs(g.a) > zero) & from_sphere);
    }

    /// Of a segment that comes from beyond the escape sphere nothing counts before it enters that.
    void skip_what_lies_beyond(const Vec3<V>& a, const Vec3<V>& b, Segments<W>& segments) const {
        const S radius = S(task_.job.escape_radius);
        const MaskOf<V> beyond = dot(a, a) > V(radius * radius);
        if (!any(beyond)) return;
        const V entry = chord_fraction(sphere_level(V(radius)), a, b, V(S(0)));
        float entries[W];
        to_floats(pick(beyond & (entry > V(S(0))) & (entry < V(S(1))), entry, V(S(0))), entries);
        for (int i = 0; i < W; ++i) segments.near[i] = std::max(segments.near[i], entries[i]);
    }

    /// Cuts the part of a → b that is asked about down, in double, to the cube ±far_away/2 around the scene; false when it misses it.
    bool clip(const Vec3<V>& a, const Vec3<V>& b, int i, Segments<W>& segments, V& begin, V& length) const {
        const double head[3] = {double(get_lane(a.x, i)), double(get_lane(a.y, i)), double(get_lane(a.z, i))};
        const double tail[3] = {double(get_lane(b.x, i)), double(get_lane(b.y, i)), double(get_lane(b.z, i))};
        const double first = double(get_lane(begin, i)), nearest = first + double(get_lane(length, i)) * double(segments.near[i]);
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
        for (int k = 0; k < 3; ++k) segments.org[k][i] = float(org[k] + enter * dir[k]), segments.dir[k][i] = float(rest * dir[k]);
        return true;
    }

    /// As fractions of the step.
    V length_of_pieces(V sagitta) const {
        V length(S(1));
        for (int pieces = 1; pieces < most_pieces; pieces *= 2) {
            const MaskOf<V> bent = sagitta > V(tolerance_);
            if (!any(bent)) break;
            length = pick(bent, V(S(0.5)) * length, length);
            sagitta = V(S(0.25)) * sagitta;
        }
        return length;
    }
    /// As many of them as fit.
    static V whole_pieces(const V& way, const V& piece) {
        const V fit = min(way / piece, V(S(most_pieces))), nearest = nearest_whole(fit);
        return pick(nearest > fit, nearest - V(S(1)), nearest) * piece;
    }
    static constexpr int most_pieces = 1024;
    /// Closer to a surface floats do not tell its sides, in Embree's coordinates of order one: some 30 roundings.
    static constexpr float start_offset = 4e-6f;
    /// Beyond this segments are cut down to the scene first, in the same coordinates.
    static constexpr float far_away = 32;

    const Task<V>& task_;
    const Geometry& geometry_;
    S tolerance_;
    bool chord_only_, timed_, in_the_open_;
    ClearBox<V> clear_ = task_.first_box;
    V queries_ = S(0);
    std::uint64_t fresh_ = 0;    ///< lanes of which no piece has been asked about
    std::uint64_t leaving_ = 0;  ///< lanes that were too close to a surface which they leave, in the piece before
};

}  // namespace kagero
