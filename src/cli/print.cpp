// kagero print: the scene written back whole, with every default.
#include "cli/verb.h"
#include "error.h"

#include <filesystem>
#include <ostream>

namespace kagero {

namespace {

void declare(CLI::App& app, Arguments& arguments) {
    add_scene(app, arguments);
    add_option(app, "-o,--output", arguments.output, "Where it goes; '-', the default, is stdout", "FILE");
    add_messages(app, arguments);
}

int run(const Arguments& arguments, const Terminal&) {
    const std::string output = arguments.output.empty() ? "-" : arguments.output;
    const SceneDescription scene = scene_of(arguments, options_of(arguments));
    if (output != "-" && std::filesystem::exists(output) && std::filesystem::equivalent(output, arguments.scene))
        throw InputError("-o " + output + ": that is the scene itself");
    check_output(output);
    write_output(output, [&](std::ostream& out) { out << print_scene(scene); });
    return exit_done;
}

}  // namespace

const Verb print_verb{"print", "Write a scene back whole, with every default", declare, run};

}  // namespace kagero
