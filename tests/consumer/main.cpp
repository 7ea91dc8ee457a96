// A program that uses the installed library, to test it: consumer SCENE.toml PICTURE KEY=VALUE…
//
// Renders the scene to PICTURE and prints the chosen precision, integrator and step. The exit status is 0, or
// identifies the check that has failed.
#include <kagero/kagero.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace {

/// Returns true if a ray hits a named object, and a ray without direction fails with a reason.
bool rays_are_traced(const kagero::SceneSource& source) {
    const auto rays = kagero::trace_rays(source, {{{0, -0.85, 0.12}, {1, 0, 0}}, {{0, -0.85, 0.12}, {0, 0, 0}}});
    return rays.size() == 2 && rays[0].status == "hit" && !rays[0].object.empty() && rays[1].status == "failed" &&
           !rays[1].reason.empty();
}

/// Returns true if the action of a straight ray of a medium with index 1 is its length, a column that was not requested
/// is empty, and one that the space does not have is refused.
bool integrals_are_computed(const kagero::SceneSource& source) {
    kagero::SceneSource flat = source;
    flat.overrides.push_back("space={hamiltonian=\"flat\"}");
    const kagero::Ray ray{{0, -0.85, 0.12}, {1, 0, 0}};
    const auto traced = kagero::trace_rays(flat, {ray}, {}, {}, {"action"});
    const double length = std::hypot(traced[0].position[0] - ray.position[0], traced[0].position[1] - ray.position[1],
                                     traced[0].position[2] - ray.position[2]);
    if (!traced[0].action || traced[0].time || !(length > 0)) return false;
    if (std::abs(*traced[0].action - length) > 1e-12 * length) return false;
    try {
        kagero::trace_rays(flat, {ray}, {}, {}, {"actoin"});
    } catch (const kagero::InputError& error) {
        return std::string(error.what()).find("action, time") != std::string::npos;
    }
    return false;
}

/// Returns true if a loaded scene gives the numbers of render_scene and trace_rays, and does not change.
bool loaded_scene_is_the_same(const kagero::SceneSource& source) {
    const kagero::LoadedScene scene = kagero::load(source.file, source.overrides);
    const kagero::LoadedScene small = scene.override({"film.size=[16, 8]"});
    const kagero::Picture picture = small.render({}, {"steps", "color"}), again = small.render({}, {"steps", "color"});
    if (picture.width() != 16 || picture.height() != 8 || picture.channels("steps") != 1) return false;
    const float *color = picture.pixels("color"), *color_again = again.pixels("color");
    if (!std::equal(color, color + std::size_t{16} * 8 * 3, color_again)) return false;
    if (scene.source().overrides != source.overrides || small.explain().empty()) return false;
    const std::vector<kagero::Ray> rays{{{0, -0.85, 0.12}, {1, 0, 0}}};
    const auto by_scene = scene.trace(rays), by_source = kagero::trace_rays(source, rays);
    return by_scene[0].position == by_source[0].position && by_scene[0].object == by_source[0].object;
}

/// Returns true if a ray continues at a mirror only with bounces, and its weight is then the tint of the mirror. The
/// scene is a text without a file.
bool rays_continue_at_mirrors() {
    const char* text =
        "[space]\nhamiltonian = \"flat\"\n[[object]]\nname = \"hall\"\nshape = \"room\"\n"
        "min = [-1, -1, -1]\nmax = [1, 1, 1]\nmaterial = \"mirror\"\ntint = [0.5, 0.5, 0.5]\n";
    const kagero::LoadedScene hall = kagero::load(kagero::SceneSource{"hall.toml", {}, text});
    const std::vector<kagero::Ray> rays{{{0, -0.85, 0.12}, {1, 0.1, 0}}};
    kagero::TraceOptions request;
    request.bounces = 2;
    const auto ended = hall.trace(rays), continued = hall.trace(rays, request);
    return ended[0].bounces == 0 && ended[0].weight == 1 && continued[0].bounces == 2 &&
           std::abs(continued[0].weight - 0.25) < 1e-12 && continued[0].reason == "bounces";
}

/// Returns true if an unknown key is refused with a message that names it.
bool unknown_key_is_refused(const kagero::SceneSource& source) {
    kagero::SceneSource wrong = source;
    wrong.overrides.push_back("camera.fovv=40");
    try {
        kagero::render_scene(wrong);
    } catch (const kagero::InputError& error) {
        return std::string(error.what()).find("fovv") != std::string::npos;
    }
    return false;
}

}  // namespace

int main(int argc, char** argv) {
    const kagero::SceneSource source{argv[1], {argv + 3, argv + argc}};
    const kagero::Picture picture = kagero::render_scene(source);
    const kagero::RunChoices& choices = picture.choices();
    std::printf("%s %s %.9g\n", choices.precision.c_str(), choices.integrator.c_str(), choices.step);
    if (choices.max_pixel_error > 0 && !(choices.bound_is_met && choices.estimated_error <= choices.max_pixel_error))
        return 2;
    if (picture.rays() < std::uint64_t(picture.width()) * picture.height() || picture.channels("color") != 3) return 3;
    if (!std::isfinite(picture.pixels("color")[0]) || choices.explanation.find("left out") == std::string::npos)
        return 4;
    picture.write(argv[2]);
    if (!rays_are_traced(source)) return 5;
    if (!integrals_are_computed(source)) return 7;
    if (!loaded_scene_is_the_same(source)) return 8;
    if (!rays_continue_at_mirrors()) return 9;
    return unknown_key_is_refused(source) ? 0 : 6;
}
