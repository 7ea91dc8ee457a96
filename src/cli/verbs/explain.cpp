// kagero explain: prints the plan for a scene without rendering it.
#include "cli/output.h"
#include "cli/resolve.h"
#include "cli/verb.h"
#include "report/explanation.h"

#include <ostream>

namespace kagero {

namespace {

void declare_explain(CLI::App& app, Arguments& arguments) {
    add_scene(app, arguments);
    add_json(app, arguments);
    add_execution(app, arguments);
    add_lanes(app, arguments);
    add_messages(app, arguments);
}

int run_explain(const Arguments& arguments, const Terminal& terminal) {
    const Options options = options_of(arguments);
    SceneDescription scene = scene_of(arguments, options);
    check_outputs({{"--json", arguments.json}}, files_of(scene));
    const Plan plan = resolve_with_progress(std::move(scene), options, terminal);
    const bool json = !arguments.json.empty();
    const std::string text = json ? explanation_json(plan) : explanation_text(plan);
    write_output(json ? arguments.json : "-", [&](std::ostream& out) { out << text; });
    return exit_done;
}

}  // namespace

const Verb explain_verb{"explain",
                        "Print the plan for a scene: features in use, and features left out with the reasons",
                        declare_explain, run_explain};

}  // namespace kagero
