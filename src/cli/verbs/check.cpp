// kagero check: checks whether a scene is valid.
#include "cli/output.h"
#include "cli/verb.h"
#include "error.h"
#include "frames/frame_plans.h"
#include "report/explanation.h"
#include "report/warnings.h"
#include "tuning/step_bound.h"
#include "tuning/trial_run.h"

#include <ostream>

namespace kagero {

namespace {

void declare_check(CLI::App& app, Arguments& arguments) {
    add_scene(app, arguments);
    add_json(app, arguments);
    add_execution(app, arguments);
    add_lanes(app, arguments);
    add_messages(app, arguments);
}

int run_check(const Arguments& arguments, const Terminal& terminal) {
    const Options options = options_of(arguments);
    const bool json = !arguments.json.empty();
    check_outputs({{"--json", arguments.json}}, {{"the scene", arguments.scene}});
    const auto write_report = [&](const std::string& text) {
        write_output(json ? arguments.json : "-", [&](std::ostream& out) { out << text; });
    };
    // Calls `make`. If it throws InputError, writes the JSON report of the error first.
    const auto with_error_report = [&](const auto& make) {
        try {
            return make();
        } catch (const InputError& error) {
            if (json && !arguments.scene.empty()) write_report(invalidity_json(arguments.scene, error.what()));
            throw;
        }
    };
    SceneDescription scene = with_error_report([&] { return scene_of(arguments, options); });
    check_outputs({{"--json", arguments.json}}, files_of(scene));
    with_error_report([&] {
        if (scene.animation) check_frames(scene, catalogue(options.isa), {0, scene.animation->frames, 1});
    });
    // make_plan also reads meshes and textures, and refuses methods that cannot integrate the space.
    const Plan plan = with_error_report([&] {
        return choose_step_bound(make_plan(std::move(scene), options), options, Purpose::picture);
    });
    for (const std::string& remark : plan.remarks) terminal.warning(remark);
    const std::vector<Warning> warnings = warnings_of(plan, trace_trial(plan), "in a trial of the picture");
    for (const Warning& warning : warnings) terminal.warning(warning.text);
    write_report(json ? validity_json(plan, warnings) : validity_text(plan));
    return exit_done;
}

}  // namespace

const Verb check_verb{"check", "Check whether a scene is valid, and report the first error", declare_check, run_check};

}  // namespace kagero
