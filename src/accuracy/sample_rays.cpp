#include "accuracy/sample_rays.h"

#include "rays/camera.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// Angle between a ray and its neighbours in radians. It is small compared with the details of a picture, and large
/// compared with the error of a reference ray (1e-13).
constexpr double neighbour_offset_angle = 1e-7;

/// Returns the Morton code of a grid point. An aligned run of 2^n codes is a compact block of the grid.
std::uint64_t morton_code(std::uint32_t x, std::uint32_t y) {
    std::uint64_t code = 0;
    for (int bit = 0; bit < 32; ++bit)
        code |= std::uint64_t((x >> bit) & 1) << (2 * bit) | std::uint64_t((y >> bit) & 1) << (2 * bit + 1);
    return code;
}

}  // namespace

std::vector<std::array<double, 2>> sample_pixels(const FilmDescription& film, std::uint32_t width,
                                                 std::uint32_t height) {
    const std::uint32_t columns = std::min(width, film.width), rows = std::min(height, film.height);
    std::vector<std::array<std::uint32_t, 2>> grid;
    for (std::uint32_t y = 0; y < rows; ++y)
        for (std::uint32_t x = 0; x < columns; ++x) grid.push_back({x, y});
    std::sort(grid.begin(), grid.end(),
              [](const auto& a, const auto& b) { return morton_code(a[0], a[1]) < morton_code(b[0], b[1]); });
    std::vector<std::array<double, 2>> pixels;
    for (const auto& [column, row] : grid)
        pixels.push_back({std::floor((column + 0.5) * film.width / columns) + 0.5,
                          std::floor((row + 0.5) * film.height / rows) + 0.5});
    return pixels;
}

SampleRays sample_rays(const Plan& plan, std::vector<std::array<double, 2>> pixels) {
    SampleRays sample;
    sample.pixel_angle = pixel_size(plan.description(), 1);
    sample.neighbour_angle = neighbour_offset_angle;
    sample.pixels = std::move(pixels);
    const double offset = neighbour_offset_angle / sample.pixel_angle;
    for (const auto& [x, y] : sample.pixels) {
        sample.starts.push_back(camera_ray_start(plan, x, y));
        sample.right.push_back(camera_ray_start(plan, x + offset, y));
        sample.below.push_back(camera_ray_start(plan, x, y + offset));
    }
    return sample;
}

SampleRays sample_rays(const Plan& plan, std::uint32_t width, std::uint32_t height) {
    const FilmDescription& film = plan.description().film;
    SampleRays sample = sample_rays(plan, sample_pixels(film, width, height));
    sample.width = std::min(width, film.width);
    sample.height = std::min(height, film.height);
    return sample;
}

}  // namespace kagero
