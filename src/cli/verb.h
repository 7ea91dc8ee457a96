/// The verbs of the command line. Each verb is one file in verbs/ and one row of the table in main.cpp.
#pragma once

#include "cli/arguments.h"
#include "cli/terminal.h"

namespace kagero {

/// One verb, `kagero NAME`.
struct Verb {
    const char* name;
    const char* description;                                           ///< One line for the help text.
    void (*declare)(CLI::App& app, Arguments& arguments);              ///< Adds the options of the verb.
    int (*run)(const Arguments& arguments, const Terminal& terminal);  ///< Runs the verb; returns the exit status.
};

extern const Verb render_verb, trace_verb, explain_verb, check_verb, print_verb, compare_verb, error_verb,
    stability_verb, profile_verb, list_verb, merge_verb, view_verb, sweep_verb;

/// Exit statuses.
inline constexpr int exit_done = 0;
inline constexpr int exit_failed = 1;         ///< The run failed, for example because a file could not be written.
inline constexpr int exit_wrong_input = 2;    ///< The command line, the scene or the data is invalid.
inline constexpr int exit_bound = 4;          ///< The run finished, but a stated bound or a stability case failed.
inline constexpr int exit_interrupted = 130;  ///< The run was interrupted.

}  // namespace kagero
