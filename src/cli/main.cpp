#include "cli/verb.h"
#include "error.h"
#include "parts/tile_file.h"
#include "report/listing.h"
#include "scene/reader.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <exception>
#include <iostream>
#include <new>

namespace {

using namespace kagero;

// A new verb needs one more row here.
const Verb* const verbs[] = {&render_verb,  &merge_verb, &trace_verb,   &sweep_verb, &explain_verb,
                             &check_verb,   &print_verb, &compare_verb, &error_verb, &stability_verb,
                             &profile_verb, &view_verb,  &list_verb};

constexpr const char* exit_statuses =
    "`kagero VERB --help` shows the options of a verb.\n"
    "Exit status: 0 finished; 1 failed while running; 2 wrong command line, scene or data; 4 finished, but a stated "
    "bound or a stability case failed; 130 interrupted (the results so far are written).";

/// Throws InputError for a first word that is not a verb.
[[noreturn]] void refuse_verb(const std::string& word) {
    if (word.starts_with('-'))
        throw InputError("the option \"" + word + "\" precedes the verb; write `kagero VERB [OPTIONS]`");
    std::vector<std::string> names;
    for (const Verb* verb : verbs) names.push_back(verb->name);
    throw InputError("there is no verb \"" + word + "\"" + suggestion(word, names));
}

/// Throws InputError if the verb was given words that CLI11 could not assign to an option or positional argument.
void refuse_unknown_words(const CLI::App& app) {
    const std::vector<std::string> unknown = app.remaining();
    if (unknown.empty()) return;
    const auto option = std::find_if(unknown.begin(), unknown.end(),
                                     [](const std::string& word) { return word.size() > 1 && word[0] == '-'; });
    if (option == unknown.end())
        throw InputError(app.get_name() + ": unexpected argument \"" + unknown.front() + "\"; `kagero " +
                         app.get_name() + " --help` shows the usage");
    std::vector<std::string> known;
    for (const CLI::Option* each : app.get_options())
        for (const std::string& name : each->get_lnames()) known.push_back("--" + name);
    const std::string word = option->substr(0, option->find('='));
    throw InputError(app.get_name() + " has no option \"" + word + "\"" + suggestion(word, known));
}

/// Throws InputError for `--json ''`. CLI11 does not distinguish an empty value from a missing one.
void refuse_empty_json(const CLI::App& verb, const Arguments& arguments) {
    const CLI::Option* json = verb.get_option_no_throw("--json");
    if (json && json->count() > 0 && arguments.json.empty()) throw InputError("--json: the value is empty");
}

/// Moves the value of `--json` to the scene, or to the topic of `list`, if no scene or topic was given and the value
/// names one. Also moves it to the parts of `merge` if it is a part file. In `render --json room.toml`, CLI11 assigns
/// room.toml to --json, because the value of --json is optional.
void restore_positional(Arguments& arguments, const std::string& verb) {
    if (verb == "merge" && is_tile_file(arguments.json)) {
        arguments.parts.push_back(arguments.json);
        arguments.json = "-";
    }
    if (verb == "merge") return;
    std::string& positional = verb == "list" ? arguments.topic : arguments.scene;
    if (!positional.empty()) return;
    const bool misplaced = verb == "list" ? json_is_positional(arguments.json, list_topics(), "a topic")
                                          : arguments.json.ends_with(".toml");
    if (!misplaced) return;
    positional = arguments.json;
    arguments.json = "-";
}

/// Returns the command line without the program name, in reverse order, as CLI11 expects it. A word after "--" is a
/// file, even if it begins with '-'; "./" is added to it, so that CLI11 does not treat it as an option.
std::vector<std::string> words_of(int argc, char** argv) {
    std::vector<std::string> words;
    bool options_allowed = true;
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        if (options_allowed && word == "--") options_allowed = false;
        else words.push_back(!options_allowed && word.starts_with('-') ? "./" + word : word);
    }
    std::reverse(words.begin(), words.end());
    return words;
}

int run(int argc, char** argv, Arguments& arguments) {
    CLI::App app("Renders scenes in which light bends.", "kagero");
    app.set_version_flag("--version", "kagero " KAGERO_VERSION);
    app.footer(exit_statuses);
    app.get_formatter()->label("SUBCOMMAND", "VERB");
    app.require_subcommand(0, 1);
    app.allow_extras();
    app.option_defaults()->multi_option_policy(
        CLI::MultiOptionPolicy::TakeLast);  // The last value of an option counts, so that users can override scripts.
    for (const Verb* verb : verbs)
        verb->declare(*app.add_subcommand(verb->name, verb->description)->group("Verbs")->allow_extras(), arguments);
    try {
        app.parse(words_of(argc, argv));
    } catch (const CLI::Success& success) {  // --help or --version
        const int status = app.exit(success);
        if (!std::cout.flush()) throw RunError("writing the result to stdout failed");
        return status;
    } catch (const CLI::ArgumentMismatch& error) {  // "--size: 1 required WxH missing"
        const std::string text = error.what();
        throw InputError(text.substr(0, text.find(':')) + " needs a value");
    } catch (const CLI::ParseError& error) {
        throw InputError(error.what());
    }
    const auto chosen = app.get_subcommands();
    if (!app.remaining().empty()) refuse_verb(app.remaining().front());
    if (chosen.empty()) throw InputError("no verb was given; `kagero --help` shows the verbs");
    refuse_unknown_words(*chosen.front());
    require_one_of("--color", arguments.color, {"auto", "always", "never"});
    refuse_empty_json(*chosen.front(), arguments);
    restore_positional(arguments, chosen.front()->get_name());
    const auto verb = std::find_if(std::begin(verbs), std::end(verbs),
                                   [&](const Verb* v) { return chosen.front()->get_name() == v->name; });
    return (*verb)->run(arguments, Terminal(arguments));
}

}  // namespace

int main(int argc, char** argv) {
    Arguments arguments;
    try {
        return run(argc, argv, arguments);
    } catch (const kagero::InputError& error) {
        Terminal(arguments).error(error.what());
        return exit_wrong_input;
    } catch (const kagero::Interrupted& interrupted) {
        Terminal(arguments).note(interrupted.what());
        return exit_interrupted;
    } catch (const std::bad_alloc&) {
        Terminal(arguments).error("not enough memory");
        return exit_failed;
    } catch (const std::exception& error) {
        Terminal(arguments).error(error.what());
        return exit_failed;
    }
}
