// kagero print: writes a scene with all default values.
#include "scene/print.h"
#include "cli/output.h"
#include "cli/verb.h"

#include <ostream>

namespace kagero {

namespace {

void declare_print(CLI::App& app, Arguments& arguments) {
    add_scene(app, arguments);
    add_option(app, "-o,--output", arguments.output, "File for the scene; '-' is stdout. Default: -", "FILE");
    add_messages(app, arguments);
}

int run_print(const Arguments& arguments, const Terminal&) {
    const std::string output = arguments.output.empty() ? "-" : arguments.output;
    const SceneDescription scene = scene_of(arguments, options_of(arguments));
    check_outputs({{"-o", output}}, files_of(scene));
    write_output(output, [&](std::ostream& out) { out << print_scene(scene); });
    return exit_done;
}

}  // namespace

const Verb print_verb{"print", "Write a scene as TOML, with all overrides and default values", declare_print,
                      run_print};

}  // namespace kagero
