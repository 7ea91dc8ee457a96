/// Everything the command line can say, and the options that several verbs share.
#pragma once

#include "plan/plan.h"

#include <cstdint>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace kagero {

/// The command line as written; `x_of` functions below turn it into values. Empty means not given.
struct Arguments {
    std::string scene, output, topic;
    std::string json;  ///< "-": stdout
    std::vector<std::string> overrides, cases;
    std::string threads, isa, strategy = "auto", precision = "auto";
    std::string integrator, step, size, spp, seed, layers, crop, pixel, lanes;
    std::string rays = "-", observer, parameter, repeat, sample, methods, equal_error, rounds, schedule = "auto",
                time_limit;
    std::string color = "auto";
    bool maps = false, path = false, quick = false, full = false, quiet = false, verbose = false;
    bool several_isas = false;  ///< the verb takes a list of them, or all
};

// What CLI11 does, in one place: it takes the compiler longer than everything that a verb says.
void add_option(CLI::App& verb, const std::string& names, std::string& value, const std::string& what,
                const std::string& type);
void add_option(CLI::App& verb, const std::string& names, std::vector<std::string>& values, const std::string& what,
                const std::string& type);
void add_flag(CLI::App& verb, const std::string& names, bool& value, const std::string& what);

// Declare options that several verbs share. `add_scene` also takes those that are short for a key of the scene.
void add_messages(CLI::App& verb, Arguments& arguments);
void add_json(CLI::App& verb, Arguments& arguments);
void add_isa(CLI::App& verb, Arguments& arguments, bool several);
void add_scene(CLI::App& verb, Arguments& arguments, bool several_isas = false);
void add_lanes(CLI::App& verb, Arguments& arguments);
void add_machine(CLI::App& verb, Arguments& arguments, const std::string& threads = "all");
void add_schedule(CLI::App& verb, Arguments& arguments);
void add_crop(CLI::App& verb, Arguments& arguments);

/// Reads the scene, with -D and what is short for it. Throws InputError.
SceneDescription scene_of(const Arguments& arguments, const Options& options);
/// The same without the plane of the orbit, unless the scene states a method that follows it.
SceneDescription general_scene_of(Arguments arguments, const Options& options);
/// Threads, instruction set and strategy, and the crop. Throws InputError.
Options options_of(const Arguments& arguments);
/// --crop and --pixel name pixels that the film has. Throws InputError.
void check_inside(const std::string& option, const std::string& given, const FilmDescription& film, std::uint32_t x,
                  std::uint32_t y);
/// … and --crop, if it is given.
void check_crop(const Arguments& arguments, const Options& options, const FilmDescription& film);

/// The words between separators, empty ones included.
std::vector<std::string> split(const std::string& text, char separator);
/// Whole numbers between separators: "640x480", "1,2". Throws InputError naming the option unless there are exactly
/// `count`.
std::vector<std::uint32_t> whole_numbers(const std::string& option, const std::string& text, char separator,
                                         std::size_t count);
/// How many, from 1 to `most`. Throws InputError naming the option.
std::uint32_t count_of(const std::string& option, const std::string& text, std::uint32_t most);
/// A finite number. Throws InputError naming the option.
double finite_number(const std::string& option, const std::string& text);
/// Throws InputError, with a near match, unless `word` is one of `known`.
void require_one_of(const std::string& option, const std::string& word, const std::vector<std::string>& known);
/// `--json` takes a file if a word follows it. Whether the word is one of `known`; throws InputError where it looks
/// like one misspelt. `kind` is "a topic".
bool json_took_word(const std::string& json, const std::vector<std::string>& known, const std::string& kind);

}  // namespace kagero
