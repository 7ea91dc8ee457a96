// Another program that uses kagero: consumer SCENE.toml PICTURE KEY=VALUE… prints what was chosen, as "precision
// integrator step", and writes the picture.
#include <kagero/error.h>
#include <kagero/picture.h>
#include <kagero/rays.h>

#include <cmath>
#include <cstdio>

namespace {

bool traces_a_ray(const kagero::SceneSource& source) {
    const auto rays = kagero::trace_rays(source, {{{0, -0.85, 0.12}, {1, 0, 0}}, {{0, -0.85, 0.12}, {0, 0, 0}}});
    return rays.size() == 2 && rays[0].status == "hit" && !rays[0].object.empty() && rays[1].status == "failed" &&
           !rays[1].reason.empty();
}

bool refuses_a_misspelt_key(const kagero::SceneSource& source) {
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
    if (!traces_a_ray(source)) return 5;
    return refuses_a_misspelt_key(source) ? 0 : 6;
}
