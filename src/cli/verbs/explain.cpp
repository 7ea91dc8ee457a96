// kagero explain: what would run for a scene, and what is left out of it.
#include "cli/resolve.h"
#include "cli/output.h"
#include "cli/verb.h"
#include "report/explanation.h"

#include <ostream>

namespace kagero {

namespace {

void declare(CLI::App& app, Arguments& arguments) {
    add_scene(app, arguments);
    add_json(app, arguments);
    add_machine(app, arguments);
    add_lanes(app, arguments);
    add_messages(app, arguments);
}

int run(const Arguments& arguments, const Terminal& terminal) {
    const Options options = options_of(arguments);
    SceneDescription scene = scene_of(arguments, options);
    check_outputs({{"--json", arguments.json}}, files_of(scene));
    const Plan plan = resolve_watched(std::move(scene), options, terminal);
    const bool json = !arguments.json.empty();
    const std::string text = json ? explanation_json(plan) : explanation_text(plan);
    write_output(json ? arguments.json : "-", [&](std::ostream& out) { out << text; });
    return exit_done;
}

}  // namespace

const Verb explain_verb{"explain", "Say what would run for a scene, and what is left out and why", declare, run};

}  // namespace kagero
