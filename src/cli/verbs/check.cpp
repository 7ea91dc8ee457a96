// kagero check: is the scene right?
#include "cli/output.h"
#include "cli/verb.h"
#include "error.h"
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
    const bool json = !arguments.json.empty();
    check_outputs({{"--json", arguments.json}}, {{"the scene", arguments.scene}});
    const auto report = [&](const std::string& text) {
        write_output(json ? arguments.json : "-", [&](std::ostream& out) { out << text; });
    };
    const auto or_report = [&](const auto& make) {
        try {
            return make();
        } catch (const InputError& error) {
            if (json && !arguments.scene.empty()) report(invalidity_json(arguments.scene, error.what()));
            throw;
        }
    };
    SceneDescription scene = or_report([&] { return scene_of(arguments, options); });
    check_outputs({{"--json", arguments.json}}, files_of(scene));
    // Making the plan reads meshes and textures too, and refuses what cannot be integrated.
    const auto plan = or_report([&] { return make_plan(std::move(scene), options); });
    for (const std::string& remark : plan.remarks) terminal.warning(remark);
    report(json ? validity_json(plan) : validity_text(plan));
    return exit_done;
}

}  // namespace

const Verb check_verb{"check", "Say whether a scene is valid, and what is wrong with it", declare, run};

}  // namespace kagero
