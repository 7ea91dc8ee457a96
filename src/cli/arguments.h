/// The arguments of the command line, and the options that several verbs share.
#pragma once

#include "plan/plan.h"
#include "scene/load/load.h"

#include <cstdint>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace kagero {

/// The texts of the command line. Functions such as `options_of` convert them to values. An empty string means that the
/// option was not given.
struct Arguments {
    std::string scene, output, topic;
    std::string json;  ///< File for the JSON report; "-" is stdout; "" without --json.
    std::vector<std::string> overrides, cases;
    std::string threads, isa, strategy = "auto", precision = "auto";
    std::string integrator, step, tolerance, size, spp, seed, sampling, layers, crop, pixel, lanes;
    std::string rays = "-", observer, parameter, columns, every;
    std::string part, frames;
    std::vector<std::string> parts;   ///< Files of `merge`.
    std::vector<std::string> varied;  ///< Keys of `sweep` with their values.
    bool resume = false, incomplete = false, mpi = false, send_files = false;
    std::string bounces, repeat, sample, methods, baseline, equal_error, rounds, seconds, schedule = "auto", time_limit;
    std::string port = "8080", bind = "127.0.0.1";
    std::string color = "auto";
    bool maps = false, path = false, quick = false, full = false, quiet = false, verbose = false;
    bool several_isas = false;  ///< True if the verb accepts several names in --isa, or "all".
};

// Wrappers of CLI11. They are in one file because templates of CLI11 take long to compile. `type` names the value in
// the help text.
/// Adds an option with one value, which must not be empty or begin with "--".
void add_option(CLI::App& verb, const std::string& names, std::string& value, const std::string& help,
                const std::string& type);
/// Adds an option or positional argument with any number of values.
void add_option(CLI::App& verb, const std::string& names, std::vector<std::string>& values, const std::string& help,
                const std::string& type);
/// Adds an option without a value.
void add_flag(CLI::App& verb, const std::string& names, bool& value, const std::string& help);

/// Adds --columns. `use` is a sentence that states where the columns appear.
void add_columns(CLI::App& verb, Arguments& arguments, const std::string& use);

/// Requests the integrals of --columns. Throws InputError for other names.
void request_columns(const Arguments& arguments, Options& options);

/// Adds --quiet, --verbose and --color, which control the messages on stderr.
void add_messages(CLI::App& verb, Arguments& arguments);
/// Adds --json.
void add_json(CLI::App& verb, Arguments& arguments);
/// Adds --isa. `several` is true if the verb accepts a list of instruction sets.
void add_isa(CLI::App& verb, Arguments& arguments, bool several);
/// Adds the scene, -D, --isa, and the options that set one key of the scene.
void add_scene(CLI::App& verb, Arguments& arguments, bool several_isas = false);
/// Adds --lanes.
void add_lanes(CLI::App& verb, Arguments& arguments);
/// Adds --threads, --strategy and --precision. `threads` describes the default number of threads in the help text.
void add_execution(CLI::App& verb, Arguments& arguments, const std::string& threads = "the number of processors");
/// Adds --schedule.
void add_schedule(CLI::App& verb, Arguments& arguments);
/// Adds --crop.
void add_crop(CLI::App& verb, Arguments& arguments);

/// Returns the overrides of -D, followed by those of the options that set one key of the scene. Throws InputError.
std::vector<Override> overrides_of(const Arguments& arguments);
/// Reads the scene and applies -D and the options that set a key. Throws InputError.
SceneDescription scene_of(const Arguments& arguments, const Options& options, SceneUse use = SceneUse::picture);
/// As scene_of, but with a text that was read before. `path` is that of the scene file.
SceneDescription scene_of_text(const Arguments& arguments, const Options& options, const std::string& text,
                               const std::string& path, SceneUse use = SceneUse::picture);
/// Returns the options for instruction set, strategy, precision, schedule, threads and crop. Throws InputError.
Options options_of(const Arguments& arguments);
/// Checks that pixel (x, y) lies in the film. `given` is the value of the option as written. Throws InputError.
void check_inside(const std::string& option, const std::string& given, const FilmDescription& film, std::uint32_t x,
                  std::uint32_t y);
/// Checks that --crop, if given, lies in the film. Throws InputError.
void check_crop(const Arguments& arguments, const Options& options, const FilmDescription& film);

/// Returns the parts of a text between separators, empty parts included.
std::vector<std::string> split(const std::string& text, char separator);
/// Parses whole numbers between separators, such as "640x480" or "1,2". Throws InputError with the name of the option
/// unless the text contains exactly `count` numbers.
std::vector<std::uint32_t> whole_numbers(const std::string& option, const std::string& text, char separator,
                                         std::size_t count);
/// Parses a whole number from `min` to `max`. Throws InputError with the name of the option.
std::uint32_t count_of(const std::string& option, const std::string& text, std::uint32_t max, std::uint32_t min = 1);
/// Parses a finite number. Throws InputError with the name of the option.
double finite_number(const std::string& option, const std::string& text);
/// Throws InputError unless `word` is one of `words`. The message suggests a similar word.
void require_one_of(const std::string& option, const std::string& word, const std::vector<std::string>& words);
/// Returns true if the value of `--json` is one of `words`, which are the positional arguments that the verb accepts.
/// The value of `--json` is optional, so CLI11 takes a positional argument that follows `--json` as its value. Throws
/// InputError if the value resembles one of the words. `kind` names the words in the message, for example "a topic".
bool json_is_positional(const std::string& json, const std::vector<std::string>& words, const std::string& kind);

}  // namespace kagero
