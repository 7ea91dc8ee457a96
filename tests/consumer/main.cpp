// Another program that renders a scene: consumer SCENE.toml PICTURE
#include <film/film.h>
#include <render/render.h>
#include <scene/description.h>

int main(int, char** argv) {
    const auto plan = kagero::make_plan(kagero::load_scene(argv[1], {"film.size=[64,64]"}, kagero::catalogue("auto")), {});
    kagero::Film film(64, 64, plan->scene.film.layers);
    const kagero::RunReport report = kagero::render(*plan, film);
    kagero::write_film(film, argv[2], {});
    return report.rays == 64 * 64 ? 0 : 1;
}
