#include "cli/verb.h"
#include "error.h"
#include "report/listing.h"
#include "scene/reader.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <exception>
#include <iostream>
#include <new>

namespace {

using namespace kagero;

// One row is one more verb.
const Verb* const verbs[] = {&render_verb,  &trace_verb, &explain_verb,   &check_verb,   &print_verb,
                             &compare_verb, &error_verb, &stability_verb, &profile_verb, &list_verb};

constexpr const char* exit_statuses =
    "`kagero VERB --help` shows the options of a verb.\n"
    "Exit status: 0 done; 1 failed while running; 2 wrong command line, scene or data; 4 a stated bound or case "
    "failed; 130 "
    "interrupted (what was done is "
    "written).";

[[noreturn]] void refuse_verb(const std::string& word) {
    if (word.starts_with('-')) throw InputError("options stand behind the verb; \"" + word + "\" stands before it");
    std::vector<std::string> names;
    for (const Verb* verb : verbs) names.push_back(verb->name);
    throw InputError("there is no verb \"" + word + "\"" + suggestion(word, names));
}

/// What the library could not place, in our words.
void refuse_leftovers(const CLI::App& app) {
    const std::vector<std::string> left = app.remaining();
    if (left.empty()) return;
    const auto option = std::find_if(left.begin(), left.end(),
                                     [](const std::string& word) { return word.size() > 1 && word[0] == '-'; });
    if (option == left.end())
        throw InputError(app.get_name() + " does not know what to do with \"" + left.front() + "\"");
    std::vector<std::string> known;
    for (const CLI::Option* each : app.get_options())
        for (const std::string& name : each->get_lnames()) known.push_back("--" + name);
    const std::string word = option->substr(0, option->find('='));
    throw InputError(app.get_name() + " has no option \"" + word + "\"" + suggestion(word, known));
}

/// The library takes an empty word for none.
void refuse_empty_json(const CLI::App& verb, const Arguments& arguments) {
    const CLI::Option* json = verb.get_option_no_throw("--json");
    if (json && json->count() > 0 && arguments.json.empty()) throw InputError("--json: an empty value");
}

/// `--json` takes a file if one follows, so in `render --json room.toml` it took the scene. Give it back.
void return_what_json_took(Arguments& arguments, const std::string& verb) {
    std::string& wanted = verb == "list" ? arguments.topic : arguments.scene;
    if (!wanted.empty()) return;
    const bool took =
        verb == "list" ? json_took_word(arguments.json, list_topics(), "a topic") : arguments.json.ends_with(".toml");
    if (!took) return;
    wanted = arguments.json;
    arguments.json = "-";
}

/// The words behind the program's name, last first as the library wants them. Behind "--" there are only files,
/// whatever they begin with.
std::vector<std::string> words_of(int argc, char** argv) {
    std::vector<std::string> words;
    bool options = true;
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        if (options && word == "--") options = false;
        else words.push_back(!options && word.starts_with('-') ? "./" + word : word);
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
        CLI::MultiOptionPolicy::TakeLast);  // so that a script's options can be overruled
    for (const Verb* verb : verbs)
        verb->declare(*app.add_subcommand(verb->name, verb->what)->group("Verbs")->allow_extras(), arguments);
    try {
        app.parse(words_of(argc, argv));
    } catch (const CLI::Success& asked) {  // help or version
        const int status = app.exit(asked);
        if (!std::cout.flush()) throw RunError("cannot write all of the result to stdout");
        return status;
    } catch (const CLI::ArgumentMismatch& error) {  // "--size: 1 required WxH missing"
        const std::string text = error.what();
        throw InputError(text.substr(0, text.find(':')) + " needs a value");
    } catch (const CLI::ParseError& error) {
        throw InputError(error.what());
    }
    const auto chosen = app.get_subcommands();
    if (!app.remaining().empty()) refuse_verb(app.remaining().front());
    if (chosen.empty()) throw InputError("what shall be done? `kagero --help` shows the verbs");
    refuse_leftovers(*chosen.front());
    require_one_of("--color", arguments.color, {"auto", "always", "never"});
    refuse_empty_json(*chosen.front(), arguments);
    return_what_json_took(arguments, chosen.front()->get_name());
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
        Terminal(arguments).error("there is not enough memory");
        return exit_failed;
    } catch (const std::exception& error) {
        Terminal(arguments).error(error.what());
        return exit_failed;
    }
}
