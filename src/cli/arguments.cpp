#include "cli/arguments.h"

#include "compiler/formula_compiler.h"
#include "error.h"
#include "modules/modules.h"
#include "plan/names.h"
#include "scene/load/load.h"
#include "scene/reader.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <optional>

namespace kagero {

namespace {

constexpr std::uint32_t max_threads = 4096;

/// Parses the whole text as a number. Returns nothing if it is not a number of this type.
template <class Number>
std::optional<Number> parsed(const std::string& text) {
    Number number{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc{} || end != text.data() + text.size()) return {};
    return number;
}

/// Returns a text that is a whole number, without leading zeros. Throws InputError for other texts. The reader of the
/// scene checks the range.
std::string checked_integer(const std::string& option, const std::string& text) {
    const auto number = parsed<std::int64_t>(text);
    if (!number) throw InputError(option + ": '" + text + "' is not a whole number");
    return std::to_string(*number);
}

/// The value of an option, or of an environment variable if the option is not given. `source` is the name of the option
/// or variable that gave the value.
struct OptionValue {
    std::string source, text;
    OptionValue(const char* option, const std::string& given, const char* variable) : source(option), text(given) {
        const char* value = std::getenv(variable);
        if (given.empty() && value && *value) {
            source = variable;
            text = value;
        }
    }
};

/// Refuses an empty value, such as an unset variable of a script, and an option in place of a missing value.
CLI::Validator value_validator() {
    const auto find_error = [](std::string& text) -> std::string {
        if (text.empty()) return "the value is empty";
        return text.starts_with("--") ? "the value is missing; the next word is the option " + text : "";
    };
    return {find_error, ""};
}

}  // namespace

std::vector<Override> overrides_of(const Arguments& arguments) {
    std::vector<Override> all(arguments.overrides.begin(), arguments.overrides.end());
    const auto add = [&](const char* option, const std::string& given, const char* key, const auto& value) {
        if (!given.empty()) all.emplace_back(std::string(key) + "=" + value(given), std::string(option) + " " + given);
    };
    const auto word = [](const std::string& text) { return to_toml(text); };
    const auto integer = [](const char* option) {
        return [option](const std::string& text) { return checked_integer(option, text); };
    };
    add("--integrator", arguments.integrator, "integrator.method", word);
    add("--step", arguments.step, "integrator.step",
        [](const std::string& text) { return to_toml(finite_number("--step", text)); });
    add("--tolerance", arguments.tolerance, "integrator.tolerance",
        [](const std::string& text) { return to_toml(finite_number("--tolerance", text)); });
    add("--lanes", arguments.lanes, "integrator.lanes",
        [&](const std::string& text) { return text == "auto" ? word(text) : checked_integer("--lanes", text); });
    add("--size", arguments.size, "film.size", [](const std::string& text) {
        const auto size = split(text, 'x');
        if (size.size() != 2)
            throw InputError("--size: '" + text + "' is not a width and a height separated by 'x', such as 640x480");
        return "[" + checked_integer("--size", size[0]) + ", " + checked_integer("--size", size[1]) + "]";
    });
    add("--spp", arguments.spp, "film.spp", integer("--spp"));
    add("--seed", arguments.seed, "film.seed", integer("--seed"));
    add("--sampling", arguments.sampling, "film.sampling", word);
    add("--layers", arguments.layers, "film.layers", [](const std::string& text) {
        std::string list;
        for (const std::string& layer : split(text, ',')) append_to_list(list, to_toml(layer));
        return "[" + list + "]";
    });
    return all;
}

void add_option(CLI::App& verb, const std::string& names, std::string& value, const std::string& help,
                const std::string& type) {
    verb.add_option(names, value, help)->type_name(type)->check(value_validator());
}

void add_option(CLI::App& verb, const std::string& names, std::vector<std::string>& values, const std::string& help,
                const std::string& type) {
    verb.add_option(names, values, help)->type_name(type);
}

void add_flag(CLI::App& verb, const std::string& names, bool& value, const std::string& help) {
    verb.add_flag(names, value, help);
}

void add_messages(CLI::App& verb, Arguments& arguments) {
    add_flag(verb, "--quiet", arguments.quiet, "Print errors only: no progress, warnings or notes");
    add_flag(verb, "--verbose", arguments.verbose, "Print details of the run, such as the kernel and the load time");
    add_option(verb, "--color", arguments.color,
               "Colours of messages on stderr: auto, always or never. auto: if stderr is a terminal and NO_COLOR is "
               "empty or not set. Default: auto",
               "WHEN");
}

void add_columns(CLI::App& verb, Arguments& arguments, const std::string& use) {
    add_option(verb, "--columns", arguments.columns,
               "Integrals along the ray, separated by commas: action, time. " + use +
                   " action is the integral of p·dq, time the integral of ∂H/∂pt dλ; both belong to H itself. Default: "
                   "none",
               "A,B");
}

void request_columns(const Arguments& arguments, Options& options) {
    if (arguments.columns.empty()) return;
    for (const std::string& column : split(arguments.columns, ',')) {
        require_one_of("--columns", column, integral_names());
        request_integral(options, column);
    }
}

void add_json(CLI::App& verb, Arguments& arguments) {
    verb.add_option("--json", arguments.json,
                    "Write a report as JSON to FILE. Without FILE, or if FILE is '-', the JSON is written to stdout "
                    "instead of other results")
        ->expected(0, 1)
        ->default_str("-")
        ->type_name("[FILE]");
}

void add_isa(CLI::App& verb, Arguments& arguments, bool several) {
    const char* help =
        several ? "Instruction sets: names from `kagero list isas`, separated by commas, or all that this processor "
                  "supports. Default: KAGERO_ISA if set, otherwise all for compare and the best one for stability"
                : "Instruction set: auto (the best one) or a name from `kagero list isas` that this processor "
                  "supports. Default: KAGERO_ISA if set, otherwise auto";
    add_option(verb, "--isa", arguments.isa, help, several ? "A,B" : "NAME");
    if (several) verb.parse_complete_callback([&arguments] { arguments.several_isas = true; });
}

void add_scene(CLI::App& verb, Arguments& arguments, bool several_isas) {
    add_option(verb, "SCENE", arguments.scene, "The scene: a TOML file", "");
    verb.add_option("-D", arguments.overrides,
                    "Set a key of the scene, for example -D space.rg=0.1. VALUE is TOML, or a word without quotes. The "
                    "option may be repeated; the last value of a key counts")
        ->type_name("KEY=VALUE")
        ->expected(1)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    add_option(verb, "--integrator", arguments.integrator,
               "Integration method, a name from `kagero list integrators` (key integrator.method). Default: chosen for "
               "the space",
               "NAME");
    add_option(verb, "--step", arguments.step,
               "Step in the integration parameter, 0 < H <= 1e12; in radians for orbit-* and mino-* methods (key "
               "integrator.step). Methods with step control use it for their first step. Default: chosen for the space",
               "H");
    add_option(verb, "--tolerance", arguments.tolerance,
               "Bound on the local error of each step of a method with step control, 0 < T < 1 (key "
               "integrator.tolerance). Default: chosen for the picture; 1e-10 for `trace`",
               "T");
    add_option(verb, "--size", arguments.size,
               "Width and height of the film in pixels, each 1 to 65536 (key film.size). Default: the value in the "
               "scene",
               "WxH");
    add_option(verb, "--spp", arguments.spp, "Rays per pixel, 1 to 65536 (key film.spp). Default: 1", "N");
    add_option(verb, "--seed", arguments.seed,
               "Seed of the positions of rays within a pixel, 0 to 4294967295 (key film.seed). It has an effect only "
               "with several rays per pixel. Default: 0",
               "N");
    add_option(
        verb, "--sampling", arguments.sampling,
        "full: the rays of all pixels are traced; adaptive: ray ends are interpolated where the error is at most "
        "film.max_interpolation_error (key film.sampling). Default: full",
        "full|adaptive");
    add_option(verb, "--layers", arguments.layers,
               "Layers of the picture, names from `kagero list layers` separated by commas (key film.layers). Default: "
               "color",
               "A,B");
    add_isa(verb, arguments, several_isas);
}

void add_lanes(CLI::App& verb, Arguments& arguments) {
    add_option(verb, "--lanes", arguments.lanes,
               "Rays per packet: auto, or a number from `kagero list strategies` (key integrator.lanes). Default: auto",
               "N");
}

void add_execution(CLI::App& verb, Arguments& arguments, const std::string& threads) {
    add_option(verb, "--threads", arguments.threads,
               "Number of threads, 1 to 4096. Default: KAGERO_THREADS if set, otherwise " + threads, "N");
    add_option(verb, "--strategy", arguments.strategy,
               "Vectorization strategy: auto, scalar, per-ray or packet; see `kagero list strategies`. auto: packet "
               "(scalar if integrator.lanes is 1); compare, error and stability measure several strategies. Default: "
               "auto",
               "NAME");
    add_option(verb, "--precision", arguments.precision,
               "Precision of the integration: auto, double or float. auto: double, except for pictures whose trial "
               "rays show no visible difference in float; compare, error and stability measure both. Default: auto",
               "NAME");
}

void add_schedule(CLI::App& verb, Arguments& arguments) {
    add_option(verb, "--schedule", arguments.schedule,
               "Order in which threads process the picture: auto, scanline (rows), tiles (squares, row by row) or "
               "predicted (squares, the costliest first). The picture does not depend on it. Default: auto",
               "NAME");
}

void add_crop(CLI::App& verb, Arguments& arguments) {
    add_option(verb, "--crop", arguments.crop,
               "Render only the pixels with X0 <= x < X1 and Y0 <= y < Y1; pixel (0, 0) is at the top left. Default: "
               "the whole film",
               "X0,Y0,X1,Y1");
}

SceneDescription scene_of(const Arguments& arguments, const Options& options, SceneUse use) {
    if (arguments.scene.empty())
        throw InputError(
            "no scene was given; name a TOML file (`kagero list scenes` shows the scenes that are "
            "distributed with kagero)");
    return load_scene(arguments.scene, overrides_of(arguments), catalogue(options.isa), use);
}

SceneDescription scene_of_text(const Arguments& arguments, const Options& options, const std::string& text,
                               const std::string& path, SceneUse use) {
    return load_scene_text(text, path, overrides_of(arguments), catalogue(options.isa), use);
}

Options options_of(const Arguments& arguments) {
    Options options;
    if (const OptionValue isa("--isa", arguments.isa, "KAGERO_ISA"); !isa.text.empty()) {
        options.isa = isa.text;
        if (!arguments.several_isas) require_isa(isa.source, isa.text);
        else if (isa.text != "all")
            for (const std::string& one : split(isa.text, ',')) require_isa(isa.source, one);
    }
    require_one_of("--strategy", arguments.strategy, {"auto", "scalar", "per-ray", "packet"});
    options.strategy = strategy_named(arguments.strategy);
    require_one_of("--precision", arguments.precision, {"auto", "double", "float"});
    options.precision = precision_named(arguments.precision);
    std::vector<std::string> schedules = schedule_names();
    schedules.insert(schedules.begin(), "auto");
    require_one_of("--schedule", arguments.schedule, schedules);
    options.schedule = schedule_named(arguments.schedule);
    if (const OptionValue threads("--threads", arguments.threads, "KAGERO_THREADS"); !threads.text.empty())
        options.threads = count_of(threads.source, threads.text, max_threads);
    check_formula_variable();
    if (!arguments.crop.empty()) {
        const auto edges = whole_numbers("--crop", arguments.crop, ',', 4);
        if (edges[0] >= edges[2] || edges[1] >= edges[3])
            throw InputError("--crop: '" + arguments.crop + "' is empty; X0,Y0,X1,Y1 must have X0 < X1 and Y0 < Y1");
        options.crop = {edges[0], edges[1], edges[2], edges[3]};
    }
    return options;
}

void check_inside(const std::string& option, const std::string& given, const FilmDescription& film, std::uint32_t x,
                  std::uint32_t y) {
    if (x >= film.width || y >= film.height)
        throw InputError(option + ": " + given + " is outside the film of " + std::to_string(film.width) + "x" +
                         std::to_string(film.height) + " pixels; pixel coordinates start at 0");
}

void check_crop(const Arguments& arguments, const Options& options, const FilmDescription& film) {
    if (!arguments.crop.empty()) check_inside("--crop", arguments.crop, film, options.crop.x1 - 1, options.crop.y1 - 1);
}

std::vector<std::string> split(const std::string& text, char separator) {
    std::vector<std::string> parts(1);
    for (const char c : text) {
        if (c == separator) parts.emplace_back();
        else parts.back() += c;
    }
    return parts;
}

std::vector<std::uint32_t> whole_numbers(const std::string& option, const std::string& text, char separator,
                                         std::size_t count) {
    std::vector<std::uint32_t> numbers;
    for (const std::string& part : split(text, separator)) {
        const auto number = parsed<std::uint32_t>(part);
        if (!number) break;
        numbers.push_back(*number);
    }
    const std::size_t separators = static_cast<std::size_t>(std::count(text.begin(), text.end(), separator));
    if (numbers.size() != count || separators + 1 != count)
        throw InputError(option + ": '" + text + "' is not " + std::to_string(count) +
                         " whole numbers, 0 or greater, separated by '" + separator + "'");
    return numbers;
}

std::uint32_t count_of(const std::string& option, const std::string& text, std::uint32_t max, std::uint32_t min) {
    const auto number = parsed<std::uint32_t>(text);
    if (!number || *number < min || *number > max)
        throw InputError(option + ": '" + text + "' is " + (number ? "out of range" : "not a whole number") +
                         "; it must be from " + std::to_string(min) + " to " + std::to_string(max));
    return *number;
}

double finite_number(const std::string& option, const std::string& text) {
    const auto number = parsed<double>(text);
    if (!number || !std::isfinite(*number)) throw InputError(option + ": '" + text + "' is not a finite number");
    return *number;
}

void require_one_of(const std::string& option, const std::string& word, const std::vector<std::string>& words) {
    if (std::find(words.begin(), words.end(), word) != words.end()) return;
    throw InputError(option + ": \"" + word + "\" is not a possible value" + suggestion(word, words));
}

bool json_is_positional(const std::string& json, const std::vector<std::string>& words, const std::string& kind) {
    if (std::find(words.begin(), words.end(), json) != words.end()) return true;
    const std::string near = json.find_first_of("./") == std::string::npos ? near_match(json, words) : "";
    if (!near.empty())
        throw InputError("--json: \"" + json + "\" is not " + kind + "; did you mean " + near +
                         "? (A file of this name is written as ./" + json + ")");
    return false;
}

}  // namespace kagero
