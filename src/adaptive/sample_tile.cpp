#include "adaptive/sample_tile.h"

#include "adaptive/bundle.h"
#include "adaptive/displacement.h"
#include "adaptive/end_interpolant.h"
#include "appearance/sky_view.h"
#include "rays/end_distance.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// A square of pixels, by its first pixel in the tile.
struct PixelCell {
    std::uint32_t x, y, edge;
    bool clear;  ///< True if no ray in the cell can meet a surface on which its nodes do not end.
};
/// Edge of the smallest cells, in pixels. In smaller cells, half of the rays would be nodes and tests.
constexpr std::uint32_t smallest_cell = 8;

/// Returns the edge of the largest cells, in pixels. A formula can contain a feature so narrow that it bends no ray of
/// the nodes of a cell of 32 × 32 pixels. The built-in spaces contain no such feature.
std::uint32_t largest_cell_of(const Plan& plan) { return plan.description().space.formula ? 8 : 32; }

/// The sampling of one tile.
class TileSampler {
public:
    TileSampler(const Plan& plan, const Job& job, const Tile& tile, double bound, TracedRays& rays,
                AdaptiveSamples& samples)
        : plan_(plan), geometry_(job.geometry), tile_(tile), x0_(tile.x0 / adaptive_tile_edge * adaptive_tile_edge),
          y0_(tile.y0 / adaptive_tile_edge * adaptive_tile_edge), bound_(bound), rays_(rays), samples_(samples),
          nodes_(samples.nodes) {
        nodes_.begin(plan, job, x0_, y0_, adaptive_tile_edge);
    }

    void sample(Counters& counters, const CancelToken& cancel) {
        prepare();
        std::vector<PixelCell> cells = largest_cells(), tested, divided;
        while (!cells.empty()) {
            request_nodes(cells);
            nodes_.trace(counters);
            if (cancel()) return;  // the ends of a cancelled trace are undefined
            tested.clear();
            divided.clear();
            for (PixelCell& cell : cells) {
                const bool alike = nodes_end_alike(cell);
                cell.clear = !geometry_ || (alike && (cell.clear || is_clear(cell)));
                (alike && cell.clear ? tested : divided).push_back(cell);
            }
            for (const PixelCell& cell : tested) request_tests(cell);
            nodes_.trace(counters);
            if (cancel()) return;
            for (const PixelCell& cell : tested)
                if (!interpolate(cell)) divided.push_back(cell);
            cells.clear();
            for (const PixelCell& cell : divided) divide(cell, cells);
        }
        nodes_.trace(counters);
        for (const NodePosition& pixel : traced_pixels_) set_traced(pixel.x, pixel.y);
    }

private:
    void prepare() {
        const std::size_t pixels = std::size_t{tile_.x1 - tile_.x0} * (tile_.y1 - tile_.y0);
        rays_.list.starts.clear();
        rays_.paths.clear();
        rays_.ends.resize(pixels);
        rays_.traced.assign(pixels, false);
        rays_.cells.clear();
        samples_.interpolated.clear();
    }

    /// Returns true if the cell contains pixels of the tile, which can be smaller than adaptive_tile_edge.
    bool is_in_tile(const PixelCell& cell) const {
        return x0_ + cell.x < tile_.x1 && x0_ + cell.x + cell.edge > tile_.x0 && y0_ + cell.y < tile_.y1 &&
               y0_ + cell.y + cell.edge > tile_.y0;
    }
    std::vector<PixelCell> largest_cells() const {
        std::vector<PixelCell> cells;
        const std::uint32_t edge = largest_cell_of(plan_);
        for (std::uint32_t y = 0; y < adaptive_tile_edge; y += edge)
            for (std::uint32_t x = 0; x < adaptive_tile_edge; x += edge)
                if (const PixelCell cell{x, y, edge, !geometry_}; is_in_tile(cell)) cells.push_back(cell);
        return cells;
    }
    /// Adds the quarters of a cell, or requests all of its pixels if it is one of the smallest cells.
    void divide(const PixelCell& cell, std::vector<PixelCell>& cells) {
        if (cell.edge == smallest_cell) {
            for (std::uint32_t y = cell.y; y < cell.y + cell.edge; ++y)
                for (std::uint32_t x = cell.x; x < cell.x + cell.edge; ++x)
                    if (is_in_tile({x, y, 1, cell.clear})) {
                        nodes_.request({x, y});
                        traced_pixels_.push_back({x, y});
                    }
            return;
        }
        const std::uint32_t half = cell.edge / 2;
        for (const std::uint32_t y : {cell.y, cell.y + half})
            for (const std::uint32_t x : {cell.x, cell.x + half})
                if (const PixelCell quarter{x, y, half, cell.clear}; is_in_tile(quarter)) cells.push_back(quarter);
    }

    static NodePosition node(const PixelCell& cell, std::uint32_t i) {
        return {cell.x + i % 3 * cell.edge / 2, cell.y + i / 3 * cell.edge / 2};
    }
    static NodePosition test(const PixelCell& cell, std::uint32_t i) {
        const std::uint32_t quarter = cell.edge / 4;
        return {cell.x + quarter * (1 + 2 * (i % 2)), cell.y + quarter * (1 + 2 * (i / 2))};
    }
    void request_nodes(const std::vector<PixelCell>& cells) {
        for (const PixelCell& cell : cells)
            for (std::uint32_t i = 0; i < 9 && !cell.clear; ++i) nodes_.request_with_path(node(cell, i));
        for (const PixelCell& cell : cells)
            for (std::uint32_t i = 0; i < 9 && cell.clear; ++i) nodes_.request(node(cell, i));
    }
    void request_tests(const PixelCell& cell) {
        for (std::uint32_t i = 0; i < 4; ++i) nodes_.request(test(cell, i));
    }

    Face face_of(const RayEnd& end) const { return plan_.scene->geometry->face_of(end.surface, end.primitive); }
    bool is_on_second_sheet(const RayEnd& end) const {
        const Skies& skies = plan_.scene->sources.skies;
        return !skies.is_plain() && sky_view(skies, end).on_second_sheet;
    }
    /// Returns true if the end of a ray can lie between those of other rays with the end `other`.
    bool end_alike(const RayEnd& end, const RayEnd& other) const {
        if (end.status != other.status) return false;
        if (end.status == Status::hit) return end.surface == other.surface && face_of(end) == face_of(other);
        return end.status == Status::captured ||
               (end.status == Status::escaped && is_on_second_sheet(end) == is_on_second_sheet(other));
    }
    bool nodes_end_alike(const PixelCell& cell) const {
        const RayEnd& first = nodes_.end(node(cell, 0));
        for (std::uint32_t i = 0; i < 9; ++i)
            if (!end_alike(nodes_.end(node(cell, i)), first)) return false;
        return true;
    }

    /// Returns the part of an end that the error of interpolation refers to: the direction on the sky, or the position.
    Double3 visible_part(const RayEnd& end) const {
        if (!is_seen_by_direction(plan_, end)) return {end.q[0], end.q[1], end.q[2]};
        const Skies& skies = plan_.scene->sources.skies;
        return skies.is_plain() ? Double3{end.v[0], end.v[1], end.v[2]} : sky_view(skies, end).direction;
    }
    /// Returns the derivatives of the ends around a test ray, from the four nodes around it.
    EndDerivatives derivatives_at_test(const PixelCell& cell, std::uint32_t i) const {
        const std::uint32_t first = i % 2 + 3 * (i / 2);
        const Double3 a = visible_part(nodes_.end(node(cell, first))),
                      b = visible_part(nodes_.end(node(cell, first + 1))),
                      c = visible_part(nodes_.end(node(cell, first + 3))),
                      d = visible_part(nodes_.end(node(cell, first + 4)));
        const double inverse = 1.0 / cell.edge;  // the mean of two differences over half an edge
        return {scaled(subtract(add(b, d), add(a, c)), inverse), scaled(subtract(add(c, d), add(a, b)), inverse)};
    }
    /// Returns the greatest error of the interpolated ends of the test rays, in pixels; infinity if one of them ends
    /// otherwise.
    double test_error(const PixelCell& cell, EndInterpolant& interpolant) const {
        double greatest = 0;
        for (std::uint32_t i = 0; i < 4; ++i) {
            const RayEnd& traced = nodes_.end(test(cell, i));
            if (!end_alike(traced, nodes_.end(node(cell, 4)))) return std::numeric_limits<double>::infinity();
            if (traced.status == Status::captured) continue;
            RayEnd interpolated;
            interpolant.set_row(0.5 + i / 2);
            interpolant.write(0.5 + i % 2, interpolated);
            const Double3 error = subtract(visible_part(interpolated), visible_part(traced));
            greatest = std::max(greatest, displacement_in_pixels(derivatives_at_test(cell, i), error,
                                                                 pixel_size_at(plan_, traced)));
        }
        return greatest;
    }
    /// Returns keeps_clear for the paths of the cell's rays.
    bool is_clear(const PixelCell& cell) const {
        const RayEnd& middle = nodes_.end(node(cell, 4));
        const auto path = [&](std::uint32_t i) { return nodes_.path(node(cell, i)); };
        return keeps_clear({path(4), {path(0), path(1), path(2), path(3), path(5), path(6), path(7), path(8)}},
                           *geometry_, middle.status == Status::hit ? std::optional(face_of(middle)) : std::nullopt);
    }
    /// Adds a cell whose nodes end alike to those whose ends are interpolated. Returns false if this is not accurate
    /// enough. Only the cell's own rays are used, so that the ends do not depend on other cells.
    bool interpolate(const PixelCell& cell) {
        EndLattice lattice;
        for (std::uint32_t i = 0; i < 9; ++i) lattice[i] = &nodes_.end(node(cell, i));
        EndInterpolant interpolant(lattice);
        const double error = test_error(cell, interpolant);
        if (!(error <= bound_)) return false;
        RayCell& added = rays_.cells.emplace_back();
        added.x = cell.x + x0_;
        added.y = cell.y + y0_;
        added.edge = cell.edge;
        added.error = error;
        for (std::uint32_t i = 0; i < 9; ++i) added.nodes[i] = *lattice[i];
        for (std::uint32_t i = 0; i < 4; ++i) added.tests[i] = nodes_.end(test(cell, i));
        samples_.interpolated.push_back({interpolated_pixels(added), error});
        return true;
    }
    /// Returns the number of the tile's pixels in a cell whose rays were not traced.
    std::uint32_t interpolated_pixels(const RayCell& cell) const {
        const std::uint32_t x0 = std::max(cell.x, tile_.x0), x1 = std::min(cell.x + cell.edge, tile_.x1),
                            y0 = std::max(cell.y, tile_.y0), y1 = std::min(cell.y + cell.edge, tile_.y1);
        std::uint32_t pixels = (x1 - x0) * (y1 - y0);
        const auto leave_out = [&](const std::array<std::uint32_t, 2>& at) {
            const std::uint32_t x = cell.x + at[0], y = cell.y + at[1];
            pixels -= at[0] < cell.edge && at[1] < cell.edge && x >= x0 && x < x1 && y >= y0 && y < y1;
        };
        for (std::uint32_t i = 0; i < 9; ++i) leave_out(cell.node_position(i));
        for (std::uint32_t i = 0; i < 4; ++i) leave_out(cell.test_position(i));
        return pixels;
    }

    std::size_t pixel_index(std::uint32_t x, std::uint32_t y) const {
        return std::size_t{y + y0_ - tile_.y0} * (tile_.x1 - tile_.x0) + (x + x0_ - tile_.x0);
    }
    /// Sets the end of a pixel to that of its traced ray.
    void set_traced(std::uint32_t x, std::uint32_t y) {
        const std::size_t i = pixel_index(x, y);
        rays_.ends[i] = nodes_.end({x, y});
        rays_.traced[i] = true;
    }

    const Plan& plan_;
    const Geometry* geometry_;
    const Tile& tile_;
    const std::uint32_t x0_, y0_;  ///< The film position of pixel (0, 0) of the tile.
    const double bound_;
    TracedRays& rays_;
    AdaptiveSamples& samples_;
    RayNodes& nodes_;
    std::vector<NodePosition> traced_pixels_;  ///< Pixels of divided cells of the smallest size.
};

}  // namespace

void sample_tile(const Plan& plan, const Job& job, const Tile& tile, double bound, TracedRays& rays,
                 AdaptiveSamples& samples, Counters& counters, const CancelToken& cancel) {
    Job cancellable = job;
    cancel.install(cancellable);
    TileSampler(plan, cancellable, tile, bound, rays, samples).sample(counters, cancel);
}

}  // namespace kagero
