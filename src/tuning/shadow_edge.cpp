#include "tuning/shadow_edge.h"

#include "rays/camera.h"

#include <algorithm>

namespace kagero {
namespace {

using Point = std::array<double, 2>;

/// Greatest number of pairs of neighbouring rays, and number of bisections. The distance of the rays of a grid of 16
/// columns on a film of 1000 pixels is halved to a hundredth of a pixel.
constexpr std::size_t max_pairs = 16;
constexpr int bisections = 12;

/// The points of a captured ray and of one that is not captured.
struct Pair {
    Point captured, visible;
};

/// Returns the pairs of neighbouring points in the rows of the grid between which the edge of a shadow passes.
std::vector<Pair> pairs_of(const SampleRays& sample, const std::vector<RayEnd>& ends) {
    std::vector<std::size_t> order(ends.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return std::array{sample.pixels[a][1], sample.pixels[a][0]} <
               std::array{sample.pixels[b][1], sample.pixels[b][0]};
    });
    std::vector<Pair> pairs;
    for (std::size_t k = 1; k < order.size(); ++k) {
        const std::size_t a = order[k - 1], b = order[k];
        const bool a_is_captured = ends[a].status == Status::captured;
        if (sample.pixels[a][1] < sample.pixels[b][1] || a_is_captured == (ends[b].status == Status::captured))
            continue;
        pairs.push_back(a_is_captured ? Pair{sample.pixels[a], sample.pixels[b]}
                                      : Pair{sample.pixels[b], sample.pixels[a]});
    }
    std::vector<Pair> chosen;  // evenly spread over all pairs
    for (std::size_t i = 0; i < std::min(max_pairs, pairs.size()); ++i)
        chosen.push_back(pairs[i * pairs.size() / std::min(max_pairs, pairs.size())]);
    return chosen;
}

}  // namespace

std::vector<Point> points_at_shadow_edge(const Plan& plan, const SampleRays& sample, const std::vector<RayEnd>& ends,
                                         const TraceRays& trace) {
    std::vector<Pair> pairs = pairs_of(sample, ends);
    std::vector<Point> points;
    for (int i = 0; i < bisections && !pairs.empty(); ++i) {
        std::vector<RayStart> starts;
        std::vector<Point> middles;
        for (const Pair& pair : pairs) {
            middles.push_back(
                {0.5 * (pair.captured[0] + pair.visible[0]), 0.5 * (pair.captured[1] + pair.visible[1])});
            starts.push_back(camera_ray_start(plan, middles.back()[0], middles.back()[1]));
        }
        const std::vector<RayEnd> middle_ends = trace(starts);
        for (std::size_t k = 0; k < pairs.size(); ++k) {
            const bool is_captured = middle_ends[k].status == Status::captured;
            (is_captured ? pairs[k].captured : pairs[k].visible) = middles[k];
            if (!is_captured) points.push_back(middles[k]);
        }
    }
    return points;
}

}  // namespace kagero
