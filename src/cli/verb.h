/// What `kagero VERB` can be. One verb is one file; it has one row in the table of main.cpp.
#pragma once

#include "cli/arguments.h"
#include "cli/terminal.h"

namespace kagero {

struct Verb {
    const char* name;
    const char* what;
    void (*declare)(CLI::App& app, Arguments& arguments);
    int (*run)(const Arguments& arguments, const Terminal& terminal);  ///< returns the exit status
};

extern const Verb render_verb, trace_verb, explain_verb, check_verb, print_verb, compare_verb, error_verb,
    stability_verb, profile_verb, list_verb;

inline constexpr int exit_done = 0, exit_failed = 1, exit_wrong_input = 2, exit_bound = 4, exit_interrupted = 130;

}  // namespace kagero
