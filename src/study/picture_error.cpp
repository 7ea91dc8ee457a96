#include "study/picture_error.h"

#include "accuracy/end_errors.h"
#include "accuracy/ray_errors.h"
#include "rays/camera.h"
#include "render/trace.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// Returns the plan of the picture, scaled down so that it is at most `width` pixels wide.
Plan small_plan(const Plan& plan, std::uint32_t width, std::uint32_t rays_per_pixel) {
    SceneDescription scene = plan.description();
    const double scale = std::min(1.0, double(width) / scene.film.width);
    const auto scaled = [&](std::uint32_t n) {
        return std::max(1u, static_cast<std::uint32_t>(std::lround(n * scale)));
    };
    scene.film.width = scaled(scene.film.width);
    scene.film.height = scaled(scene.film.height);
    scene.film.spp = rays_per_pixel;
    scene.film.layers = {"color"};
    return rebuild_plan(plan, std::move(scene), plan.run.kernel_request.isa);
}

/// Renders the picture with a variant and sets `seconds` to the render time. Returns null if the run was interrupted.
std::unique_ptr<Film> render_picture(const Plan& plan, const Variant& variant, const std::atomic<bool>* stop,
                                     double& seconds) {
    const FilmDescription& size = plan.description().film;
    auto film = std::make_unique<Film>(size.width, size.height, std::vector<std::string>{"color"});
    const RunReport report = render(plan_with_variant(plan, variant), *film, {.stop = stop});
    seconds = report.seconds;
    return report.interrupted ? nullptr : std::move(film);
}

/// Sets `wrong_pixels`, `rms` and `psnr` of the actual picture relative to the expected one.
void compare(const Film& expected, const Film& actual, PictureError& error) {
    constexpr float max_difference = 1.0f / 255;
    const float *a = expected.plane("color"), *b = actual.plane("color");
    const std::size_t pixels = std::size_t(expected.width()) * expected.height();
    std::size_t wrong = 0;
    double squares = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
        bool differs = false;
        for (std::size_t c = 3 * i; c < 3 * i + 3; ++c) {
            const double difference = double(a[c]) - double(b[c]);
            differs |= std::abs(difference) > max_difference;
            squares += difference * difference;
        }
        wrong += differs;
    }
    error.wrong_pixels = double(wrong) / double(pixels);
    error.rms = std::sqrt(squares / (3 * double(pixels)));
    if (error.rms > 0) error.psnr = -20 * std::log10(error.rms);
}

}  // namespace

ErrorMap error_map(const Plan& plan, std::uint32_t width, const Variant& reference, const std::atomic<bool>* stop) {
    const Plan small = small_plan(plan, width, 1);
    Film film(small.description().film.width, small.description().film.height, {"color", "position_error"});
    if (render_with_errors(small, film, {.stop = stop}).interrupted) return {};
    ErrorMap map{film.width(), film.height(), {}, small.description().film.tone, {}, {}};
    const std::size_t pixels = std::size_t(map.width) * map.height;
    map.color.assign(film.plane("color"), film.plane("color") + 3 * pixels);
    map.estimate.assign(film.plane("position_error"), film.plane("position_error") + pixels);
    std::vector<RayStart> starts;
    for (std::uint32_t y = 0; y < map.height; ++y)
        for (std::uint32_t x = 0; x < map.width; ++x) starts.push_back(pixel_ray_start(small, x, y));
    std::vector<RayEnd> expected, actual;
    if (trace(small, starts, actual, {.stop = stop}).interrupted) return {};
    if (trace(plan_with_variant(small, reference), starts, expected, {.stop = stop}).interrupted) return {};
    for (std::size_t i = 0; i < pixels; ++i)
        map.truth.push_back(float(pixel_error(small, to_hamiltonian_coordinates(small, expected[i]),
                                              to_hamiltonian_coordinates(small, actual[i]))));
    return map;
}

std::vector<PictureError> picture_errors(const Plan& plan, std::uint32_t width, const Variant& reference,
                                         const std::vector<Variant>& variants, const std::atomic<bool>* stop) {
    const Plan small = small_plan(plan, width, plan.description().film.spp);
    double unused = 0;
    const auto expected = render_picture(small, reference, stop, unused);
    std::vector<PictureError> errors;
    for (const Variant& variant : variants) {
        PictureError error;
        const auto actual = expected ? render_picture(small, variant, stop, error.seconds) : nullptr;
        if (!actual) break;
        const IntegratorInfo& info = info_of(plan, variant);
        error.method = info.name;
        error.adaptive = info.adaptive;
        error.precision = variant.kernel->precision;
        error.step = stated_step(plan, variant);
        compare(*expected, *actual, error);
        errors.push_back(std::move(error));
    }
    return errors;
}

}  // namespace kagero
