// kagero list: lists the names that scenes and options may use, such as those of Hamiltonians and integrators.
#include "cli/output.h"
#include "cli/verb.h"
#include "error.h"
#include "report/listing.h"

#include <ostream>

namespace kagero {

namespace {

void declare_list(CLI::App& app, Arguments& arguments) {
    std::string topics;
    for (const std::string& topic : list_topics()) append_to_list(topics, topic);
    add_option(app, "TOPIC", arguments.topic, "Topic of the list: " + topics + ". Default: all topics", "");
    add_isa(app, arguments, false);
    add_json(app, arguments);
    add_messages(app, arguments);
}

int run_list(const Arguments& arguments, const Terminal&) {
    if (!arguments.topic.empty()) require_one_of("list", arguments.topic, list_topics());
    const auto topics = arguments.topic.empty() ? list_topics() : std::vector<std::string>{arguments.topic};
    const std::string isa = options_of(arguments).isa;
    const std::string scenes = find_scene_directory();
    check_outputs({{"--json", arguments.json}});
    const bool json = !arguments.json.empty();
    const std::string text = json ? listing_json(topics, isa, scenes) : listing_text(topics, isa, scenes);
    write_output(json ? arguments.json : "-", [&](std::ostream& out) { out << text; });
    return exit_done;
}

}  // namespace

const Verb list_verb{"list",
                     "List the available Hamiltonians, integrators, strategies, instruction sets, scenes and layers",
                     declare_list, run_list};

}  // namespace kagero
