// kagero check: is the scene right?
#include "cli/verb.h"

#include <ostream>

namespace kagero {

namespace {

void declare(CLI::App& app, Arguments& arguments) {
    add_scene(app, arguments);
    add_machine(app, arguments);
    add_lanes(app, arguments);
    add_messages(app, arguments);
}

int run(const Arguments& arguments, const Terminal& terminal) {
    const Options options = options_of(arguments);
    // Making the plan reads meshes and textures too, and refuses what cannot be integrated.
    const auto plan = make_plan(scene_of(arguments, options), options);
    for (const std::string& remark : plan->remarks) terminal.warning(remark);
    write_output("-", [&](std::ostream& out) {
        out << arguments.scene << ": valid (" << plan->scene.space.hamiltonian << ", " << plan->scene.integrator.method << ", "
            << plan->scene.objects.size() << " objects, " << plan->scene.film.width << "x" << plan->scene.film.height << ")\n";
    });
    return exit_done;
}

}  // namespace

const Verb check_verb{"check", "Say whether a scene is valid, and what is wrong with it", declare, run};

}  // namespace kagero
