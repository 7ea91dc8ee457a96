/// Intersects steps with the scene. Finds the lanes that hit a surface, the surface, and the approximate position of
/// the hit on the step.
///
/// Most steps need no query: each lane stores a clear box around its ray, taken from the clearance grid. A step that
/// leaves its clear boxes is divided into pieces. The chord of each piece is within Job::chord_tolerance of the dense
/// output, and Embree intersects the chords.
#pragma once

#include "kernels/events/chord_query.h"
#include "kernels/intersection/clearance.h"
#include "kernels/intersection/stopwatch.h"

namespace kagero {

/// Intersects the steps of one packet with the scene.
template <class V>
class SceneIntersector {
    using S = ScalarOf<V>;
    static constexpr int W = lane_count<V>;

public:
    std::uint64_t ticks = 0;  ///< Processor ticks spent in queries; counted only if Job::timed is set.

    explicit SceneIntersector(const Task<V>& task)
        : task_(task), geometry_(*task.job.geometry), tolerance_(S(task.job.chord_tolerance)),
          chord_only_(task.job.hit == HitModel::chord), chords_(task) {}

    /// Returns the hits; they are valid in the lanes that the last call of an `intersect` function has returned.
    const SurfaceHits<V>& hits() const { return chords_.hits; }
    /// Returns the query of chords, whose state depends on the history of each ray.
    ChordQuery<V>& chords() { return chords_; }
    const ChordQuery<V>& chords() const { return chords_; }

    /// Intersects the step of `lanes` and returns the lanes that hit a surface. A step that is too curved for
    /// `max_pieces` chords is not tested, and its lane is removed from `lanes`.
    std::uint64_t intersect(const StepperState<V>& step, std::uint64_t& lanes) {
        const std::uint64_t leaving =
            geometry_.clearance ? lanes & ~to_bits(clear_box_.contains(task_.extent(step))) : lanes;
        const std::uint64_t hit = leaving ? intersect_leaving(step, leaving, lanes) : 0;
        chords_.leave_surfaces(lanes);
        return hit;
    }
    /// Intersects straight segments of any length with one query. Returns the lanes that hit a surface.
    std::uint64_t intersect_straight(const Vec3<V>& start, const Vec3<V>& end, std::uint64_t lanes) {
        const Stopwatch watch(task_.job.timed, ticks);
        return chords_.template query<true>(start, end, V(S(0)), V(S(1)), lanes);
    }

private:
    /// Intersects the steps of `lanes`, which leave the stored clear boxes. First the stored box is replaced by the box
    /// around the middle of the step, which may contain the whole step. If it does not, Embree is queried. A stored box
    /// never has to be invalidated, since it stays clear when its lane gets another ray. Lanes whose step is too curved
    /// are removed from `tested`.
    __attribute__((noinline)) std::uint64_t intersect_leaving(const StepperState<V>& step, std::uint64_t lanes,
                                                              std::uint64_t& tested) {
        const Curve<V> curve = task_.curve(step);
        if (geometry_.clearance && clear_box_.update(*geometry_.clearance, curve.middle(), lanes))
            lanes &= ~to_bits(clear_box_.contains(curve.extent()));
        if (!lanes) return 0;
        const Stopwatch watch(task_.job.timed, ticks);
        const V sagitta = chord_only_ ? V(S(0)) : curve.sagitta();
        const std::uint64_t too_curved = lanes & to_bits(sagitta > V(tolerance_ * S(max_pieces) * S(max_pieces)));
        tested &= ~too_curved;
        return query_pieces(curve, piece_length_of(sagitta), lanes & ~too_curved);
    }

    /// Divides each step into pieces of length `piece_length` (a fraction of the step) and queries the pieces that are
    /// not inside a clear box. Each lane skips its clear pieces first, so that one query contains many lanes.
    std::uint64_t query_pieces(const Curve<V>& curve, const V& piece_length, std::uint64_t lanes) {
        const V one(S(1)), half(S(0.5));
        // A step of one piece is known to leave its clear box. So is the first piece of a ray that starts on a surface.
        std::uint64_t starting = lanes & chords_.starts().departing();
        const std::uint64_t divided = geometry_.clearance ? lanes & to_bits(piece_length < one) : 0;
        const Extent<V> min_times = divided ? min_times_per_length(curve.slope_extent()) : Extent<V>{};
        std::uint64_t hit = 0, open = lanes;  // open: lanes with untested pieces
        V s0(S(0));
        while (open) {
            for (std::uint64_t skipping = open & divided & ~starting; skipping;) {
                const Vec3<V> position = curve.at(s0);
                V clear_length = clear_box_.min_exit_time(position, min_times);
                if (const std::uint64_t leaving = skipping & ~to_bits(clear_length >= piece_length)) {
                    if (clear_box_.update(*geometry_.clearance, curve.at(fma(half, piece_length, s0)), leaving))
                        clear_length = clear_box_.min_exit_time(position, min_times);
                }
                const MaskOf<V> is_clear = from_bits<V>(skipping) & (clear_length >= piece_length);
                s0 = select(is_clear, min(s0 + whole_pieces(clear_length, piece_length), one), s0);
                const std::uint64_t ended = to_bits(is_clear & (s0 >= one));
                skipping = to_bits(is_clear) & ~ended;
                open &= ~ended;
            }
            if (!open) break;
            V s1 = min(s0 + piece_length, one);
            if (starting) s1 = ends_of_departure(curve, s1, starting);
            const std::uint64_t hit_now = chords_.query(curve.at(s0), curve.at(s1), s0, s1, open);
            if (starting & hit_now) begin_at_approach(curve, starting & hit_now);
            starting = 0;
            hit |= hit_now;
            open &= ~(hit | to_bits(s1 >= one));
            s0 = s1;
        }
        return hit;
    }

    /// Returns the ends of the first pieces of `lanes`, whose rays start on named surfaces. Pieces that begin to return
    /// to this surface are shortened.
    V ends_of_departure(const Curve<V>& curve, const V& end, std::uint64_t lanes) {
        if (chord_only_) return end;
        return chords_.starts().ends_of_departure(curve, end, lanes);
    }
    /// Shortens the hit pieces of `lanes`, whose rays start on named surfaces: a piece then begins where the ray begins
    /// to approach the surface that it has hit. Otherwise, refinement could find the other end of a short arc.
    void begin_at_approach(const Curve<V>& curve, std::uint64_t lanes) {
        if (chord_only_) return;
        SurfaceHits<V>& hits = chords_.hits;
        for (const int i : lanes_in(lanes & ~approaching(curve, lanes))) {
            const LevelSet<double> g = level_set_of(geometry_.surfaces[hits.surface[i]], hits.primitive[i]);
            const double begin = chords_.starts().begin_of_approach(i, g, curve, double(get_lane(hits.piece_start, i)),
                                                                    double(get_lane(hits.piece_end, i)));
            if (begin > double(get_lane(hits.piece_start, i))) set_lane(hits.t, i, S(0.5));
            set_lane(hits.piece_start, i, S(begin));
        }
    }

    /// Returns those of `lanes` whose ray clearly approaches, from the start of the piece on, the surface that it has
    /// hit.
    std::uint64_t approaching(const Curve<V>& curve, std::uint64_t lanes) const {
        const SurfaceHits<V>& hits = chords_.hits;
        const LevelSet<V> g = chords_.level_sets(lanes);
        const V after = g.value(curve.at(hits.piece_end)), rounding(S(64) * machine_epsilon<S> / S(geometry_.scale));
        const V rate = g.slope(curve.at(hits.piece_start), curve.slope(hits.piece_start));
        return lanes & to_bits((abs(after) > rounding) & (rate * after > V(S(0))));
    }

    /// Returns the length of the pieces, as a fraction of the step. It is halved until chords are within the tolerance.
    /// `sagitta` is the distance between dense output and chord of the whole step.
    V piece_length_of(V sagitta) const {
        V length(S(1));
        for (int pieces = 1; pieces < max_pieces; pieces *= 2) {
            const MaskOf<V> bent = sagitta > V(tolerance_);
            if (!any(bent)) break;
            length = select(bent, V(S(0.5)) * length, length);
            sagitta = V(S(0.25)) * sagitta;
        }
        return length;
    }
    /// Returns `length` rounded down to a whole number of pieces.
    static V whole_pieces(const V& length, const V& piece_length) {
        const V fit = min(length / piece_length, V(S(max_pieces))), nearest = nearest_integer(fit);
        return select(nearest > fit, nearest - V(S(1)), nearest) * piece_length;
    }
    /// Greatest number of pieces into which a step is divided.
    static constexpr int max_pieces = 1024;

    const Task<V>& task_;
    const Geometry& geometry_;
    S tolerance_;      ///< Job::chord_tolerance.
    bool chord_only_;  ///< True if each step is intersected as its chord.
    ClearBox<V> clear_box_ = task_.camera_clear_box;
    ChordQuery<V> chords_;
};

}  // namespace kagero
