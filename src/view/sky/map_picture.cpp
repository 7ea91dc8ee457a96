#include "view/sky/map_picture.h"

#include "render/threads.h"
#include "view/sky/sky_colors.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>

namespace kagero {
namespace {

using Seconds = std::chrono::duration<double>;

/// Rows that a thread takes at once.
constexpr std::uint32_t rows_per_band = 8;

/// Directions of the pixels of a film, in the rest frame of the observer.
struct PixelDirections {
    const CameraRays& camera;

    Double3 operator()(double x, double y) const {
        Double3 d;
        for (std::size_t k = 0; k < 3; ++k)
            d[k] = camera.corner[k] + (x + 0.5) * camera.right[k] + (y + 0.5) * camera.down[k];
        return d;
    }
};

/// Returns the blocks that the picture shows. A block between the points of the grid may be missing; its rays are then
/// traced one by one.
std::vector<std::uint32_t> visible_blocks(const PixelDirections& directions, std::uint32_t width,
                                          std::uint32_t height) {
    constexpr std::uint32_t spacing = 4;
    std::vector<char> is_visible(DirectionMap::block_count);
    for (std::uint32_t y = 0; y < height + spacing; y += spacing)
        for (std::uint32_t x = 0; x < width + spacing; x += spacing)
            is_visible[cube_point(directions(std::min(x, width - 1), std::min(y, height - 1))).block] = 1;
    std::vector<std::uint32_t> blocks;
    for (std::uint32_t i = 0; i < DirectionMap::block_count; ++i)
        if (is_visible[i]) blocks.push_back(i);
    return blocks;
}

/// A pixel whose ray is traced.
struct SinglePixel {
    std::uint32_t x, y;
    float footprint;
};

/// Numbers of interpolated pixels by the size of their error, in steps of a hundredth of the greatest permitted one.
struct ErrorCounts {
    std::array<std::uint64_t, 101> counts{};

    void add(float error) { ++counts[std::min(100u, std::uint32_t(error * float(100 / max_map_error)))]; }
    void add(const ErrorCounts& other) {
        for (std::size_t i = 0; i < counts.size(); ++i) counts[i] += other.counts[i];
    }
    /// Returns the upper end of the class that contains this share of the pixels.
    double quantile(double share) const {
        std::uint64_t all = 0, below = 0;
        for (const std::uint64_t count : counts) all += count;
        for (std::size_t i = 0; i < counts.size() && all > 0; ++i) {
            below += counts[i];
            if (double(below) >= share * double(all)) return max_map_error * double(i + 1) / 100;
        }
        return 0;
    }
};

/// What one thread finds in its rows.
struct BandResults {
    CubeRow points;  ///< Scratch memory for one row.
    std::vector<SinglePixel> singles;
    ErrorCounts errors;
};

/// Computes rows of a picture.
class RowShader {
public:
    RowShader(const Plan& plan, const DirectionMap& map, std::vector<unsigned char>& rgb)
        : plan_(plan), map_(map), directions_{plan.view.camera}, pixel_(pixel_size(plan.description(), 1)),
          inverse_pixel_(float(1 / pixel_)), colors_(plan), rgb_(rgb) {}

    void shade(std::uint32_t y, SkyRow& row, BandResults& results) const {
        const std::uint32_t width = plan_.description().film.width;
        row.resize(width);
        const auto& right = plan_.view.camera.right;
        results.points.set(directions_(0, y), {right[0], right[1], right[2]}, width);
        for (std::uint32_t x = 0; x < width; ++x) interpolate(x, y, row, results);
        colors_.shade(row, &rgb_[std::size_t(3) * y * width]);
    }
    /// Colours the pixels whose rays were traced.
    void shade_singles(const std::vector<SinglePixel>& pixels, const std::vector<SkyEnd>& ends) const {
        SkyRow row;
        row.resize(pixels.size());
        for (std::size_t i = 0; i < pixels.size(); ++i)
            row.set(i, ends[i].direction, pixels[i].footprint, ends[i].kind);
        std::vector<unsigned char> colors(3 * pixels.size());
        colors_.shade(row, colors.data());
        for (std::size_t i = 0; i < pixels.size(); ++i)
            std::copy_n(&colors[3 * i], 3,
                        &rgb_[3 * (std::size_t(pixels[i].y) * plan_.description().film.width + pixels[i].x)]);
    }
    Double3 direction(const SinglePixel& pixel) const { return directions_(pixel.x, pixel.y); }

private:
    void interpolate(std::uint32_t x, std::uint32_t y, SkyRow& row, BandResults& results) const {
        const CubePoint point = results.points[x];
        const MapBlock& block = map_.block(point.block);
        constexpr float unknown_footprint = 0.5f;
        if (block.cells == 0) return postpone({x, y, unknown_footprint}, row, results);
        const float cells = float(block.cells), s = point.s * cells, t = point.t * cells;
        const std::uint32_t column = std::min(std::uint32_t(s), block.cells - 1),
                            line = std::min(std::uint32_t(t), block.cells - 1), cell = line * block.cells + column;
        const float footprint = block.magnification[cell] * float(pixel_) * point.inverse_depth,
                    error = block.error[cell] * inverse_pixel_;
        if (!(error <= float(max_map_error))) return postpone({x, y, footprint}, row, results);
        const SkyEnd* const upper = &block.corners[line * (block.cells + 1) + column];
        const SkyEnd* const lower = upper + block.cells + 1;
        const float right = s - float(column), down = t - float(line), lower_right = right * down,
                    upper_right = right - lower_right, lower_left = down - lower_right,
                    upper_left = 1 - right - lower_left;
        std::array<float, 3> direction;
        for (std::size_t k = 0; k < 3; ++k)
            direction[k] = upper_left * upper[0].direction[k] + upper_right * upper[1].direction[k] +
                           lower_left * lower[0].direction[k] + lower_right * lower[1].direction[k];
        row.set(x, direction, footprint, upper->kind);
        results.errors.add(error);
    }
    /// Leaves a pixel black until its ray is traced.
    static void postpone(const SinglePixel& pixel, SkyRow& row, BandResults& results) {
        row.set(pixel.x, {}, 0, SkyEnd::Kind::other);
        results.singles.push_back(pixel);
    }

    const Plan& plan_;
    const DirectionMap& map_;
    PixelDirections directions_;
    double pixel_;
    float inverse_pixel_;
    SkyColors colors_;
    std::vector<unsigned char>& rgb_;
};

/// Shades all rows on the plan's threads and returns what they have found.
BandResults shade_rows(const Plan& plan, const RowShader& shader) {
    const std::uint32_t height = plan.description().film.height;
    std::vector<BandResults> results(plan.run.threads);
    std::atomic<std::uint32_t> next{0};
    run_on_threads(plan.run.threads, [&](unsigned thread) {
        SkyRow row;
        for (std::uint32_t y; (y = next.fetch_add(rows_per_band)) < height;)
            for (std::uint32_t i = y; i < std::min(y + rows_per_band, height); ++i)
                shader.shade(i, row, results[thread]);
    });
    BandResults all;
    for (const BandResults& result : results) {
        all.singles.insert(all.singles.end(), result.singles.begin(), result.singles.end());
        all.errors.add(result.errors);
    }
    return all;
}

}  // namespace

MapPicture picture_from_map(const Plan& plan, DirectionMap& map) {
    const auto begin = std::chrono::steady_clock::now();
    const FilmDescription& film = plan.description().film;
    const double pixel = pixel_size(plan.description(), 1), earlier_seconds = map.seconds();
    const std::uint64_t earlier_rays = map.rays();
    constexpr double first_cell = 8, least_cell = 1.5;  // pixels
    map.refine(plan, visible_blocks({plan.view.camera}, film.width, film.height), max_map_error * pixel,
               first_cell * pixel, least_cell * pixel);
    MapPicture picture;
    picture.rgb.resize(std::size_t(3) * film.width * film.height);
    const RowShader shader(plan, map, picture.rgb);
    const BandResults results = shade_rows(plan, shader);
    std::vector<Double3> directions;
    for (const SinglePixel& single : results.singles) directions.push_back(shader.direction(single));
    const std::vector<SkyEnd> ends = trace_sky_ends(plan, directions, picture.traced, picture.trace_seconds);
    shader.shade_singles(results.singles, ends);
    picture.traced += map.rays() - earlier_rays;
    picture.trace_seconds += map.seconds() - earlier_seconds;
    picture.max_error = results.errors.quantile(1);
    picture.p99_error = results.errors.quantile(0.99);
    picture.shade_seconds = Seconds(std::chrono::steady_clock::now() - begin).count() - picture.trace_seconds;
    return picture;
}

}  // namespace kagero
