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
    std::vector<char> is_visible(map_block_count);
    for (std::uint32_t y = 0; y < height + spacing; y += spacing)
        for (std::uint32_t x = 0; x < width + spacing; x += spacing)
            is_visible[cube_point(directions(std::min(x, width - 1), std::min(y, height - 1))).block] = 1;
    std::vector<std::uint32_t> blocks;
    for (std::uint32_t i = 0; i < map_block_count; ++i)
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
    std::vector<SinglePixel> singles;
    ErrorCounts errors;
};

/// Computes rows of a picture from a map, which is a DirectionMap or an OrbitFamily.
template <class Map>
class RowShader {
public:
    /// Memory for one row.
    struct Scratch {
        typename Map::Row directions;
        SkyRow sky;
    };

    RowShader(const Plan& plan, const Map& map, std::vector<unsigned char>& rgb)
        : plan_(plan), map_(map), directions_{plan.view.camera}, pixel_(pixel_size(plan.description(), 1)),
          inverse_pixel_(float(1 / pixel_)), colors_(plan), rgb_(rgb) {}

    void shade(std::uint32_t y, Scratch& scratch, BandResults& results) const {
        const std::uint32_t width = plan_.description().film.width;
        scratch.sky.resize(width);
        const auto& right = plan_.view.camera.right;
        map_.set_row(scratch.directions, directions_(0, y), {right[0], right[1], right[2]}, width);
        for (std::uint32_t x = 0; x < width; ++x) interpolate(x, y, scratch, results);
        colors_.shade(scratch.sky, &rgb_[std::size_t(3) * y * width]);
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
    void interpolate(std::uint32_t x, std::uint32_t y, Scratch& scratch, BandResults& results) const {
        const MapEnd end = map_.end_at(scratch.directions, x);
        const float footprint = end.magnification * float(pixel_), error = end.error * inverse_pixel_;
        if (!(error <= float(max_map_error))) return postpone({x, y, footprint}, scratch.sky, results);
        scratch.sky.set(x, end.direction, footprint, end.kind);
        results.errors.add(error);
    }
    /// Leaves a pixel black until its ray is traced.
    static void postpone(const SinglePixel& pixel, SkyRow& row, BandResults& results) {
        row.set(pixel.x, {}, 0, SkyEnd::Kind::other);
        results.singles.push_back(pixel);
    }

    const Plan& plan_;
    const Map& map_;
    PixelDirections directions_;
    double pixel_;
    float inverse_pixel_;
    SkyColors colors_;
    std::vector<unsigned char>& rgb_;
};

/// Shades all rows on the plan's threads and returns what they have found.
template <class Map>
BandResults shade_rows(const Plan& plan, const RowShader<Map>& shader) {
    const std::uint32_t height = plan.description().film.height;
    std::vector<BandResults> results(plan.run.threads);
    std::atomic<std::uint32_t> next{0};
    run_on_threads(plan.run.threads, [&](unsigned thread) {
        typename RowShader<Map>::Scratch scratch;
        for (std::uint32_t y; (y = next.fetch_add(rows_per_band)) < height;)
            for (std::uint32_t i = y; i < std::min(y + rows_per_band, height); ++i)
                shader.shade(i, scratch, results[thread]);
    });
    BandResults all;
    for (const BandResults& result : results) {
        all.singles.insert(all.singles.end(), result.singles.begin(), result.singles.end());
        all.errors.add(result.errors);
    }
    return all;
}

constexpr double first_cell = 8;  ///< Greatest width of the first cells of a map, in pixels.

/// Refines the part of a map that the picture shows. The width of cells that are not refined further is about that of a
/// pixel, because each ray beside an edge of the shadow serves one pixel.
void refine(const Plan& plan, DirectionMap& map) {
    constexpr double least_cell = 1.5;  // pixels
    const FilmDescription& film = plan.description().film;
    const double pixel = pixel_size(plan.description(), 1);
    map.refine(plan, visible_blocks({plan.view.camera}, film.width, film.height), max_map_error * pixel,
               first_cell * pixel, least_cell * pixel);
}
/// Refines a family of orbits. Its cells may be narrower than pixels, because each ray serves a circle of pixels.
void refine(const Plan& plan, OrbitFamily& family) {
    constexpr double least_cell = 0.02;  // pixels
    const double pixel = pixel_size(plan.description(), 1);
    family.refine(plan, max_map_error * pixel, first_cell * pixel, least_cell * pixel);
}

template <class Map>
MapPicture picture_of(const Plan& plan, Map& map) {
    const auto begin = std::chrono::steady_clock::now();
    const FilmDescription& film = plan.description().film;
    const double earlier_seconds = map.seconds();
    const std::uint64_t earlier_rays = map.rays();
    refine(plan, map);
    MapPicture picture;
    picture.rgb.resize(std::size_t(3) * film.width * film.height);
    const RowShader<Map> shader(plan, map, picture.rgb);
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

}  // namespace

SkyMap new_sky_map(const Plan& plan) {
    if (OrbitFamily::contains_rays_of(plan)) return OrbitFamily(plan);
    return DirectionMap();
}

MapPicture picture_from_map(const Plan& plan, SkyMap& map) {
    return std::visit([&](auto& each) { return picture_of(plan, each); }, map);
}

}  // namespace kagero
