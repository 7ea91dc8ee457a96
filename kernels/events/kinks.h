/// Kinks: surfaces on which the derivatives of a formula jump, because a `min`, `max`, `abs` or `where` changes its
/// branch. Every method has a lower order in a step across a kink, and a derivative on the kink itself may be that of
/// the wrong side. A step therefore ends just before the kink, and the next one is so short that it passes the kink
/// without a visible error. Methods with stages outside the step, or with a stage that predicts its end, approach a
/// kink in several steps, and leave it in steps that grow, so that all stages lie on the side of the step.
#pragma once

#include "kernels/events/event.h"
#include "kernels/methods/stage_reach.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kagero {

/// The steps of a packet near kinks.
template <class V>
struct KinkSteps {
    std::uint64_t shortened = 0;  ///< Lanes whose step crosses a kink; it must be repeated with `length`.
    std::uint64_t passing = 0;    ///< Lanes whose step is the short one that passes a kink.
    V length = ScalarOf<V>(0);
};

/// Finds the kinks on the steps of one packet. The switching function of a formula is zero on its kinks and of order
/// one elsewhere.
template <class V>
class KinkSearch {
    using S = ScalarOf<V>;

public:
    explicit KinkSearch(const Task<V>& task)
        : task_(task), reach_(task.kernel.kinked ? stage_reach_of(task.method) : StageReach{}) {}

    /// Distance from a kink at which steps end before and behind it, as a value of the switching function, if this
    /// function changes by about 1 over the size of the coordinates.
    static constexpr S margin = std::is_same_v<S, float> ? S(1e-5) : S(1e-12);

    /// Returns the steps of `lanes` that cross a kink or pass it. The kink is searched on the dense output of the step.
    KinkSteps<V> find(const StepperState<V>& step, std::uint64_t lanes) {
        KinkSteps<V> found;
        const V &start = step.start.switching, no_limit(std::numeric_limits<S>::infinity());
        const Curve<V> curve = task_.curve(step);
        Bracket bracket = bracket_of(step, curve, lanes);
        const MaskOf<V> is_leaving =
            reach_.behind > 0 ? from_bits<V>(lanes) & reaches_back(step, curve) : bracket.none();
        if (!any(bracket.crossing | is_leaving)) return found;
        const V rate = rate_at_start(step);
        // Close to a kink and moving towards it: one short step, to the same distance behind the kink. Where the
        // switching function is flat, a few steps come closer to the kink before.
        const Distances distances = distances_at(step.start);
        const MaskOf<V> approaching =
            bracket.crossing & (abs(start) <= V(S(2)) * distances.approach) & (rate * start < V(S(0)));
        const MaskOf<V> is_close = abs(start) <= V(S(2)) * distances.pass;
        const V pass_length =
            select(is_close, abs(start) + distances.pass, length_before(V(S(1))) * abs(start)) / abs(rate);
        const MaskOf<V> is_short = is_close & (abs(step.h) <= V(S(4)) * pass_length);
        found.passing = to_bits(approaching & is_short);
        // Otherwise: to a point before the kink, or so short that no stage lies beyond the kink behind the start.
        narrow(step, curve, bracket, distances.approach);
        const V approach = select(bracket.crossing, length_before(bracket.before) * step.h, no_limit);
        const V departure = V(S(0.9 / std::max(reach_.behind, 1e-3))) * abs(start / rate);
        const MaskOf<V> departs = is_leaving & (rate * start > V(S(0))) & (departure < V(S(0.99)) * step.h);
        found.length = select(approaching, pass_length, min(approach, select(departs, departure, no_limit)));
        const MaskOf<V> can_shorten = (found.length > V(S(0))) & (found.length < no_limit);
        found.shortened = to_bits((bracket.crossing | departs) & can_shorten & !(approaching & is_short));
        return found;
    }

    /// Returns the lanes of `passing` (KinkSteps) in whose step H itself jumps: it changes by more than its derivatives
    /// on both sides of the kink explain.
    std::uint64_t jumping(const StepperState<V>& step, std::uint64_t passing) const {
        if (!passing) return 0;
        const V jump = task_.kernel.energy_jump(task_.system, step.start, step.end, step.h);
        return passing & ~to_bits(jump <= V(least_jump));
    }

private:
    /// Distances from a kink, as values of the switching function.
    struct Distances {
        V approach;  ///< To this distance, steps come by means of dense output.
        V pass;      ///< From this distance, a short step passes the kink to the same distance behind it.
    };
    /// Returns the distances for a kink near a state. They are small where the switching function is flat, as near one
    /// of two kinks that are close together: forces may be great there, so that the short step must be a small multiple
    /// of the rounding errors of positions. They are great where the switching function is steep, because a distance
    /// must not be shorter than these errors.
    Distances distances_at(const RayState<V>& at) const {
        constexpr bool is_float = std::is_same_v<S, float>;
        constexpr S flat = S(is_float ? 0.1 : 0.01), resolution = S(64) * machine_epsilon<S>,
                    reach_of_dense_output = is_float ? 4 : 64;
        const V slope = change_over_size(at), greatest = V(margin) * max(slope, V(S(1))),
                pass = select(slope < V(flat), V(resolution) * slope, greatest);
        return {min(V(reach_of_dense_output) * pass, greatest), min(pass, greatest)};
    }
    /// Returns the length of the gradient of the switching function in space, times the size of the coordinates.
    V change_over_size(const RayState<V>& at) const {
        const V size = greatest_component(at.q()), length = V(S(std::sqrt(machine_epsilon<S>))) * size;
        V sum(S(0));
        for (int k = 0; k < space_size; ++k) {
            State<V> beside = at;
            beside.y[k] = beside.y[k] + length;
            const V change = (task_.kernel.switching_function(task_.system, beside) - at.switching) / length;
            sum = sum + change * change;
        }
        return sqrt(sum) * size;
    }

    /// Least jump of H that ends a ray, relative to the terms of H. It is much greater than the rounding error of H,
    /// and much less than a jump that bends rays visibly.
    static constexpr S least_jump = std::is_same_v<S, float> ? S(1e-2) : S(1e-6);

    /// Fractions of a step before and behind its first kink, with the values of the switching function there.
    struct Bracket {
        V before, behind, value_before, value_behind;
        MaskOf<V> crossing;  ///< Lanes whose step, or a stage of it, lies on both sides of a kink.

        MaskOf<V> none() const { return crossing & !crossing; }
    };

    /// Greatest number of points in the search for a dip of the switching function.
    static constexpr int max_sections = 36;

    /// Returns the fraction of the step at which its last stage lies, with a reserve for the error of the prediction.
    S last_stage() const { return reach_.ahead > 0 ? S(1.02 * (1 + reach_.ahead)) : S(1); }
    /// Returns the fraction of a step to which it is shortened if it meets a kink at the fraction s. A stage that only
    /// predicts the end of a step of length h is wrong by O(h²) at least. The distance that is left for it decreases
    /// accordingly, so that a few steps approach the kink.
    V length_before(const V& s) const {
        constexpr double share_left = 0.1;
        const V within = min(s, V(S(0.98)));
        if (reach_.ahead > 0) return V(S((1 - share_left) / (1 + reach_.ahead))) * s;
        return reach_.predicts_end ? within * (V(S(1)) - V(S(share_left)) * within) : within;
    }
    /// Returns the lanes in which the first stages of the step lie beyond a kink behind its start.
    MaskOf<V> reaches_back(const StepperState<V>& step, const Curve<V>& curve) const {
        return step.start.switching * value_on(step, curve, V(S(-1.02 * reach_.behind))) < V(S(0));
    }
    /// Returns the bracket of the first kink in each lane. A step may cross two kinks, or the same one twice, so a few
    /// points between its ends are tested too, and then the point closest to zero.
    Bracket bracket_of(const StepperState<V>& step, const Curve<V>& curve, std::uint64_t lanes) const {
        const V zero(S(0)), &start = step.start.switching;
        Bracket found{zero, V(last_stage()), start, step.end.switching, from_bits<V>(0)};
        V lowest_at = zero, lowest = abs(start);  // the point closest to zero
        for (const double s : {2.0, 1.0, 0.75, 0.5, 0.25}) {
            const bool is_last = s > 1;  // the last stage, if it lies behind the end of the step
            if (is_last && !(reach_.ahead > 0)) continue;
            const V at(is_last ? last_stage() : S(s));
            const V value = s == 1 ? step.end.switching : value_on(step, curve, at);
            const MaskOf<V> crosses = from_bits<V>(lanes) & (start * value < zero);
            found.behind = select(crosses, at, found.behind);
            found.value_behind = select(crosses, value, found.value_behind);
            found.crossing = found.crossing | crosses;
            const MaskOf<V> same_side = (start * value > zero) & (at < found.behind) & (at > found.before);
            found.before = select(same_side, at, found.before);
            found.value_before = select(same_side, value, found.value_before);
            const MaskOf<V> is_lower = (value * start > zero) & (abs(value) < lowest) & (at <= V(S(1)));
            lowest = select(is_lower, abs(value), lowest);
            lowest_at = select(is_lower, at, lowest_at);
        }
        const MaskOf<V> same_side = from_bits<V>(lanes) & (!found.crossing) & (abs(start) > zero);
        if (any(same_side)) search_dip(step, curve, same_side, lowest_at, lowest, found);
        return found;
    }
    /// Searches for a crossing close to the point where the switching function comes closest to zero, in `lanes` in
    /// which all tested points lie on the same side: a thin layer between two of them, or a ray that grazes a kink. The
    /// golden section narrows the surroundings of this point; every third point is the vertex of a parabola.
    void search_dip(const StepperState<V>& step, const Curve<V>& curve, const MaskOf<V>& lanes, const V& lowest_at,
                    const V& lowest, Bracket& found) const {
        constexpr double spacing = 0.25, golden = 0.381966;  // spacing of the tested points
        const V least = max(V(S(1e-6)), rounding_on(step));
        const V zero(S(0)), one(S(1)), &start = step.start.switching;
        const V sign = select(start < zero, -one, one);
        const auto value_at = [&](const V& s) { return sign * value_on(step, curve, s); };
        const V tested = max(lowest_at - V(S(spacing)), zero);  // the last tested point before the dip
        V low = tested, high = min(lowest_at + V(S(spacing)), one), middle = lowest_at, value = lowest;
        // If the function is lowest at an end of the step, and lower beside it, it has a dip close to this end.
        const MaskOf<V> at_start = lowest_at <= zero, at_end = at_start | (lowest_at >= one);
        const auto from_end = [&](const V& distance) { return select(at_start, distance, one - distance); };
        MaskOf<V> open = lanes;
        if (any(lanes & at_end)) {
            MaskOf<V> dips = lanes & at_end & (value_at(from_end(least)) < lowest) & (least < V(S(0.1 * spacing)));
            open = lanes & (dips | !at_end);
            for (V distance = least; any(dips); distance = V(S(8)) * distance) {
                const V at = from_end(distance), there = value_at(at);
                const MaskOf<V> is_lower = dips & (there < value);
                middle = select(is_lower, at, middle);
                value = select(is_lower, there, value);
                low = select(is_lower & !at_start, one - V(S(8)) * distance, low);
                high = select(is_lower & at_start, V(S(8)) * distance, high);
                dips = dips & (value >= zero) & (distance < V(S(0.1 * spacing)));
            }
        }
        if (!any(open)) return;
        const V value_tested = value_at(tested);
        V value_low = value_at(low), value_high = value_at(high);
        for (int i = 0; i < max_sections && any(open); ++i) {
            const MaskOf<V> is_crossing = open & (value < zero);
            found.behind = select(is_crossing, middle, found.behind);
            found.value_behind = select(is_crossing, sign * value, found.value_behind);
            const MaskOf<V> is_before = value_low > zero;
            found.before = select(is_crossing, select(is_before, low, tested), found.before);
            found.value_before =
                select(is_crossing, sign * select(is_before, value_low, value_tested), found.value_before);
            found.crossing = found.crossing | is_crossing;
            open = open & (!is_crossing) & (high - low > least);
            const V to_low = middle - low, to_high = high - middle;
            const V fall = to_high * (value_low - value), rise = to_low * (value_high - value);
            const V vertex = middle + V(S(0.5)) * (to_high * fall - to_low * rise) / (fall + rise);
            const V section = select(to_high > to_low, middle + V(S(golden)) * to_high, middle - V(S(golden)) * to_low);
            const MaskOf<V> usable =
                (vertex > low) & (vertex < high) & (abs(vertex - middle) > V(S(1e-3)) * (high - low));
            const V s = i % 3 == 0 ? select(usable, vertex, section) : section, there = value_at(s);
            const MaskOf<V> is_lower = there < value;
            const MaskOf<V> is_right = s > middle;
            // The new triple surrounds the lower one of the two inner points.
            const MaskOf<V> moves_low = (is_lower & is_right) | !(is_lower | is_right);
            low = select(moves_low, select(is_lower, middle, s), low);
            value_low = select(moves_low, select(is_lower, value, there), value_low);
            high = select(moves_low, high, select(is_lower, middle, s));
            value_high = select(moves_low, value_high, select(is_lower, value, there));
            middle = select(is_lower, s, middle);
            value = select(is_lower, there, value);
        }
    }
    /// Narrows a bracket around the point at a distance before the kink, by the method of false position on the dense
    /// output (Illinois), and by bisection if that does not converge.
    void narrow(const StepperState<V>& step, const Curve<V>& curve, Bracket& bracket, const V& distance) const {
        const V zero(S(0)), &start = step.start.switching;
        auto& [before, behind, value_before, value_behind, crossing] = bracket;
        // A step that begins just behind a kink is closer to it than `distance`, which is the distance to keep from the
        // next kink. The search then needs a point between both kinks.
        MaskOf<V> near = crossing & (before <= zero) & (abs(value_before) <= distance);
        V closer = behind;
        for (int i = 0; i < 14 && any(near); ++i) {
            closer = V(S(0.25)) * closer;
            const V value = value_on(step, curve, closer);
            const MaskOf<V> is_behind = near & (value * start < zero),
                            is_found = near & (value * start > distance * abs(start));
            behind = select(is_behind, closer, behind);
            value_behind = select(is_behind, value, value_behind);
            before = select(is_found, closer, before);
            value_before = select(is_found, value, value_before);
            near = near & !is_found;
        }
        const V target = select(start < zero, -distance, distance);
        value_before = value_before - target;
        value_behind = value_behind - target;
        MaskOf<V> open = crossing;
        for (int i = 0; i < 12 || (i < 40 && any(open)); ++i) {
            const V secant = before - value_before * (behind - before) / (value_behind - value_before);
            const bool bisects = i >= 12 && i % 2 == 0;  // false position is slow where the function is very steep
            const V s = bisects ? V(S(0.5)) * (before + behind) : secant, value = value_on(step, curve, s) - target;
            const MaskOf<V> is_before = value * start > zero, usable = is_finite(s) & is_finite(value);
            value_behind = select(usable & is_before, V(S(0.5)) * value_behind, value_behind);
            value_before = select(usable & !is_before, V(S(0.5)) * value_before, value_before);
            before = select(usable & is_before, s, before);
            value_before = select(usable & is_before, value, value_before);
            behind = select(usable & !is_before, s, behind);
            value_behind = select(usable & !is_before, value, value_behind);
            open = open & !(is_before & (abs(value) <= distance));
        }
    }
    /// Returns the rounding error of a point on the step, as a fraction of the step. Within this distance, the
    /// switching function changes irregularly.
    V rounding_on(const StepperState<V>& step) const {
        const V length = abs(step.h) * greatest_component(step.start.velocity);
        return V(S(256) * machine_epsilon<S>) * greatest_component(step.start.q()) / length;
    }
    /// Returns the rate of change of the switching function along the tangent at the start of the step. The difference
    /// is taken over a length that is large compared with the rounding errors of the position.
    V rate_at_start(const StepperState<V>& step) const {
        const Vec3<V> q = step.start.q(), &v = step.start.velocity;
        const V rounding = V(S(std::sqrt(machine_epsilon<S>))) * greatest_component(q) / greatest_component(v);
        const V length = max(V(S(1e-4)) * abs(step.h), rounding);
        State<V> ahead = step.start;
        ahead.set(advance(q, length, v), step.start.p());
        return (task_.kernel.switching_function(task_.system, ahead) - step.start.switching) / length;
    }
    /// Returns the switching function on the dense output at the fraction s of the step, where the momentum is
    /// interpolated linearly.
    V value_on(const StepperState<V>& step, const Curve<V>& curve, const V& s) const {
        State<V> state = step.start;
        Vec3<V> p = step.start.p();
        const Vec3<V> change = step.end.p() - p;
        p = advance(p, s, change);
        state.set(curve.at(s), p);
        return task_.kernel.switching_function(task_.system, state);
    }

    const Task<V>& task_;
    const StageReach reach_;
};

}  // namespace kagero
