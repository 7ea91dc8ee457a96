/// The step just taken against the scene: which lanes hit what, and roughly where on the step.
///
/// Most steps ask nothing: each lane carries a budget, a distance it may still go without meeting anything, taken from the clearance
/// grid. Where the budget is short the dense output is cut into chords that stay within the tolerance and Embree is asked.
#pragma once

#include "kernels/abi.h"
#include "kernels/tracing/curve.h"
#include "kernels/tracing/segment_query.h"
#include "kernels/tracing/stopwatch.h"

#include <algorithm>
#include <cmath>

namespace kagero {

/// Raises `known`, lower bounds of the distances from q to the nearest surface, in the lanes of `lanes`.
template <class V>
void look_up_clearance(const ClearanceGrid& grid, const Vec3<V>& q, std::uint64_t lanes, V& known) {
    using S = ScalarOf<V>;
    const V per_cell(S(1 / grid.cell)), zero(S(0));
    const V at[3] = {q.x, q.y, q.z};
    V cell[3], beyond2 = zero;
    for (int k = 0; k < 3; ++k) {
        const V u = at[k] - V(S(grid.origin[k])), beyond = max(max(-u, u - V(S(grid.cells[k] * grid.cell))), zero);
        beyond2 = mul_add(beyond, beyond, beyond2);
        cell[k] = min(max(u * per_cell, zero), V(S(grid.cells[k] - 1)));
    }
    const V outside = root(beyond2);
    for (std::uint64_t rest = lanes; rest; rest &= rest - 1) {
        const int i = __builtin_ctzll(rest);
        const auto index = [&](int k) { return static_cast<std::uint32_t>(get_lane(cell[k], i)); };
        const std::size_t place = (std::size_t(index(2)) * grid.cells[1] + index(1)) * grid.cells[0] + index(0);
        const S away = get_lane(outside, i);
        set_lane(known, i, std::max(get_lane(known, i), away > S(0) ? away : S(grid.distance[place])));
    }
}

template <class V>
class Encounter {
    using S = ScalarOf<V>;
    static constexpr int W = lane_count<V>;

public:
    /// What each hit lane met.
    std::uint32_t surface[W], primitive[W];
    double from[W], to[W];    ///< the piece of the step that was hit, as fractions
    double t[W];              ///< where on that piece's chord, from Embree
    std::uint64_t queries = 0, ticks = 0;

    explicit Encounter(const Job& job) : geometry_(*job.geometry), tolerance_(S(job.chord_tolerance)),
                                         chord_only_(job.hit == HitModel::chord), timed_(job.timed) {}

    /// New ray in the lanes of `lanes`: nothing known yet, and the surface it stands on does not count.
    void begin(std::uint64_t lanes) {
        budget_ = pick(from_bits<V>(lanes), V(S(0)), budget_);
        fresh_ |= lanes;
    }

    /// Tests the step in `flow` for the lanes of `active`; returns those that hit.
    std::uint64_t meet(const Flow<V>& flow, std::uint64_t active) {
        const Curve<V> curve = Curve<V>::of_step(flow);
        const std::uint64_t asking = spend(curve, active);
        std::uint64_t hits = 0;
        if (asking) {
            const Stopwatch watch(timed_, ticks);
            hits = ask(curve, asking);
        }
        fresh_ &= ~active;
        return hits;
    }

private:
    /// Lets every lane go its way on its budget; returns the lanes whose way may lead to a surface.
    std::uint64_t spend(const Curve<V>& curve, std::uint64_t active) {
        if (!geometry_.clearance) return active;
        const V reach = curve.reach() * V(S(1.01));  // no shorter than the way to the step's end
        const std::uint64_t short_of = active & ~to_bits(reach < budget_);
        std::uint64_t asking = 0;
        if (short_of) {
            look_up_clearance(*geometry_.clearance, curve.q0, active, budget_);
            asking = short_of & ~to_bits(reach < budget_);
        }
        budget_ -= reach;
        return asking;
    }

    /// Cuts the step into pieces by the sagitta bound, each lane its own number of them, and queries piece after piece.
    std::uint64_t ask(const Curve<V>& curve, std::uint64_t asking) {
        alignas(64) S sagitta[W];
        int pieces[W] = {}, most = 1;
        put(curve.sagitta(), sagitta);
        for (std::uint64_t rest = asking; rest; rest &= rest - 1) {
            const int i = __builtin_ctzll(rest);
            pieces[i] = chord_only_ ? 1 : pieces_for(sagitta[i]);
            most = std::max(most, pieces[i]);
        }
        std::uint64_t hits = 0;
        V s0(S(0));
        Vec3<V> a = curve.q0;
        for (int piece = 0; piece < most; ++piece) {
            std::uint64_t now = 0;
            V s1(S(1));
            for (std::uint64_t rest = asking & ~hits; rest; rest &= rest - 1) {
                const int i = __builtin_ctzll(rest);
                if (piece < pieces[i]) now |= std::uint64_t(1) << i;
                set_lane(s1, i, S(std::min(piece + 1, pieces[i])) / S(pieces[i]));
            }
            if (!now) break;
            const Vec3<V> b = most == 1 ? curve.q1 : curve.at(s1);
            hits |= ask_piece(a, b, s0, s1, now, piece == 0);
            a = b, s0 = s1;
        }
        return hits;
    }

    std::uint64_t ask_piece(const Vec3<V>& a, const Vec3<V>& b, const V& s0, const V& s1, std::uint64_t now, bool first) {
        Segments<W> segments;
        const V scale(S(geometry_.scale));
        const auto to_embree = [&](const V& start, const V& end, int k) {
            narrow((start - V(S(geometry_.shift[k]))) * scale, segments.org[k]);
            narrow((end - start) * scale, segments.dir[k]);
        };
        to_embree(a.x, b.x, 0), to_embree(a.y, b.y, 1), to_embree(a.z, b.z, 2);
        for (int i = 0; i < W; ++i) {
            segments.near[i] = 0;
            if (first && ((fresh_ >> i) & 1)) {
                const float x = segments.dir[0][i], y = segments.dir[1][i], z = segments.dir[2][i];
                segments.near[i] = std::min(0.5f, start_offset / std::max(std::sqrt(x * x + y * y + z * z), start_offset));
            }
        }
        double begin[W], length[W];  // the part of each piece that is asked about, as fractions of the piece
        for (std::uint64_t rest = now; rest; rest &= rest - 1) {
            const int i = __builtin_ctzll(rest);
            begin[i] = 0, length[i] = 1;
            if (is_far(segments, i) && !clip(a, b, i, segments, begin[i], length[i])) now &= ~(std::uint64_t(1) << i);
        }
        queries += static_cast<std::uint64_t>(__builtin_popcountll(now));
        const std::uint64_t hits = query(geometry_.embree_scene, segments, now);
        for (std::uint64_t rest = hits; rest; rest &= rest - 1) {
            const int i = __builtin_ctzll(rest);
            surface[i] = segments.surface[i], primitive[i] = segments.primitive[i];
            t[i] = begin[i] + length[i] * double(segments.t[i]);
            from[i] = double(get_lane(s0, i)), to[i] = double(get_lane(s1, i));
        }
        return hits;
    }

    /// Whether an end of a segment lies so far out that float would no longer resolve the scene (or Embree refuse it); also not a number.
    static bool is_far(const Segments<W>& s, int i) {
        float greatest = 0;
        for (int k = 0; k < 3; ++k) greatest = std::max({greatest, std::abs(s.org[k][i]), std::abs(s.org[k][i] + s.dir[k][i])});
        return !(greatest < far_away);
    }
    /// Cuts a segment down, in double, to the cube ±far_away/2 around the scene; false when it misses it.
    bool clip(const Vec3<V>& a, const Vec3<V>& b, int i, Segments<W>& segments, double& begin, double& length) const {
        const double head[3] = {double(get_lane(a.x, i)), double(get_lane(a.y, i)), double(get_lane(a.z, i))};
        const double tail[3] = {double(get_lane(b.x, i)), double(get_lane(b.y, i)), double(get_lane(b.z, i))};
        double enter = 0, leave = 1, org[3], dir[3];
        for (int k = 0; k < 3; ++k) {
            org[k] = (head[k] - geometry_.shift[k]) * geometry_.scale, dir[k] = (tail[k] - head[k]) * geometry_.scale;
            const double half = 0.5 * double(far_away), u = (-half - org[k]) / dir[k], v = (half - org[k]) / dir[k];
            if (dir[k] == 0 && std::abs(org[k]) > half) return false;
            if (dir[k] != 0) enter = std::max(enter, std::min(u, v)), leave = std::min(leave, std::max(u, v));
        }
        if (!(enter < leave)) return false;
        begin = enter, length = leave - enter;
        for (int k = 0; k < 3; ++k) segments.org[k][i] = float(org[k] + enter * dir[k]), segments.dir[k][i] = float(length * dir[k]);
        return true;
    }

    /// Halving a curve divides its sagitta by four.
    int pieces_for(S sagitta) const {
        int pieces = 1;
        for (S s = sagitta; s > tolerance_ && pieces < 64; s *= S(0.25)) pieces *= 2;
        return pieces;
    }
    static void put(const V& v, S* to) { std::memcpy(to, &v, sizeof v); }
    static void narrow(const V& v, float* to) {
        alignas(64) S lanes[W];
        put(v, lanes);
        for (int i = 0; i < W; ++i) to[i] = float(lanes[i]);
    }

    /// How far from its start a ray cannot meet a surface, in Embree's coordinates of order one: some 30 roundings of float.
    static constexpr float start_offset = 4e-6f;
    /// Beyond this segments are cut down to the scene first, in the same coordinates.
    static constexpr float far_away = 32;

    const Geometry& geometry_;
    S tolerance_;
    bool chord_only_, timed_;
    V budget_{};
    std::uint64_t fresh_ = 0;
};

}  // namespace kagero
