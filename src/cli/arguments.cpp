#include "cli/arguments.h"

#include "error.h"
#include "modules/modules.h"
#include "plan/names.h"
#include "scene/load.h"
#include "scene/reader.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <optional>

namespace kagero {

namespace {

constexpr std::uint32_t most_threads = 4096;

/// All of a text as a number; none where it is no such number.
template <class Number>
std::optional<Number> parsed(const std::string& text) {
    Number number{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc{} || end != text.data() + text.size()) return {};
    return number;
}

/// A whole number as written; whether it is legal the scene's key says.
std::string whole(const std::string& option, const std::string& text) {
    const auto number = parsed<std::int64_t>(text);
    if (!number) throw InputError(option + ": '" + text + "' is not a whole number");
    return std::to_string(*number);
}

/// What an option says that a variable of the environment may stand for, and which of the two said it.
struct Said {
    std::string by, text;
    Said(const char* option, const std::string& given, const char* variable) : by(option), text(given) {
        const char* value = std::getenv(variable);
        if (given.empty() && value && *value) by = variable, text = value;
    }
};

/// -D, and the options that are short for a key of the scene.
std::vector<Override> overrides_of(const Arguments& arguments) {
    std::vector<Override> all(arguments.overrides.begin(), arguments.overrides.end());
    const auto add = [&](const char* option, const std::string& given, const char* key, const auto& value) {
        if (!given.empty()) all.emplace_back(std::string(key) + "=" + value(given), std::string(option) + " " + given);
    };
    const auto word = [](const std::string& text) { return written(text); };
    const auto count = [](const char* option) {
        return [option](const std::string& text) { return whole(option, text); };
    };
    add("--integrator", arguments.integrator, "integrator.method", word);
    add("--step", arguments.step, "integrator.step",
        [](const std::string& text) { return written(finite_number("--step", text)); });
    add("--lanes", arguments.lanes, "integrator.lanes",
        [&](const std::string& text) { return text == "auto" ? word(text) : whole("--lanes", text); });
    add("--size", arguments.size, "film.size", [](const std::string& text) {
        const auto size = split(text, 'x');
        if (size.size() != 2) throw InputError("--size: '" + text + "' is not a width and a height separated by 'x'");
        return "[" + whole("--size", size[0]) + ", " + whole("--size", size[1]) + "]";
    });
    add("--spp", arguments.spp, "film.spp", count("--spp"));
    add("--seed", arguments.seed, "film.seed", count("--seed"));
    add("--layers", arguments.layers, "film.layers", [](const std::string& text) {
        std::string list;
        for (const std::string& layer : split(text, ',')) enumerate(list, written(layer));
        return "[" + list + "]";
    });
    return all;
}

/// Empty as scripts give it whose variable is not set, or another option where a value was forgotten.
CLI::Validator a_value() {
    const auto what_is_wrong = [](std::string& text) -> std::string {
        if (text.empty()) return "an empty value";
        return text.starts_with("--") ? "its value is missing: " + text + " follows" : "";
    };
    return {what_is_wrong, ""};
}

}  // namespace

void add_option(CLI::App& verb, const std::string& names, std::string& value, const std::string& what,
                const std::string& type) {
    verb.add_option(names, value, what)->type_name(type)->check(a_value());
}

void add_option(CLI::App& verb, const std::string& names, std::vector<std::string>& values, const std::string& what,
                const std::string& type) {
    verb.add_option(names, values, what)->type_name(type);
}

void add_flag(CLI::App& verb, const std::string& names, bool& value, const std::string& what) {
    verb.add_flag(names, value, what);
}

void add_messages(CLI::App& verb, Arguments& arguments) {
    add_flag(verb, "--quiet", arguments.quiet, "No progress and no remarks");
    add_flag(verb, "--verbose", arguments.verbose, "Say what runs and how long it takes");
    add_option(verb, "--color", arguments.color,
               "Colours on the terminal: auto, always or never (NO_COLOR is honoured)", "WHEN");
}

void add_json(CLI::App& verb, Arguments& arguments) {
    verb.add_option("--json", arguments.json, "A report in JSON, on stdout or in FILE")
        ->expected(0, 1)
        ->default_str("-")
        ->type_name("[FILE]");
}

void add_isa(CLI::App& verb, Arguments& arguments, bool several) {
    const char* what =
        several ? "Instruction sets, or all that this processor has; see `kagero list isas`; else what KAGERO_ISA says"
                : "Instruction set; see `kagero list isas`; else what KAGERO_ISA says";
    add_option(verb, "--isa", arguments.isa, what, several ? "A,B" : "NAME");
    if (several) verb.parse_complete_callback([&arguments] { arguments.several_isas = true; });
}

void add_scene(CLI::App& verb, Arguments& arguments, bool several_isas) {
    add_option(verb, "SCENE", arguments.scene, "The scene, a TOML file", "");
    verb.add_option("-D", arguments.overrides, "Set any key of the scene: -D space.rg=0.1; may be repeated")
        ->type_name("KEY=VALUE")
        ->expected(1)
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    add_option(verb, "--integrator", arguments.integrator, "integrator.method; see `kagero list integrators`", "NAME");
    add_option(verb, "--step", arguments.step, "integrator.step", "H");
    add_option(verb, "--size", arguments.size, "film.size", "WxH");
    add_option(verb, "--spp", arguments.spp, "film.spp: rays per pixel", "N");
    add_option(verb, "--seed", arguments.seed, "film.seed: another choice of where in the pixel they lie", "N");
    add_option(verb, "--layers", arguments.layers, "film.layers; see `kagero list layers`", "A,B");
    add_isa(verb, arguments, several_isas);
}

void add_lanes(CLI::App& verb, Arguments& arguments) {
    add_option(verb, "--lanes", arguments.lanes, "integrator.lanes: rays per packet; see `kagero list strategies`",
               "N");
}

void add_machine(CLI::App& verb, Arguments& arguments, const std::string& threads) {
    add_option(verb, "--threads", arguments.threads, "Threads; else what KAGERO_THREADS says, or " + threads, "N");
    add_option(verb, "--strategy", arguments.strategy, "Vectorization: auto, scalar, per-ray or packet", "NAME");
    add_option(verb, "--precision", arguments.precision,
               "Of the integration: double, float, or auto: double, but for pictures that float draws as well", "NAME");
}

void add_schedule(CLI::App& verb, Arguments& arguments) {
    add_option(verb, "--schedule", arguments.schedule,
               "How threads share the picture: scanline, tiles or predicted (costly tiles first); default: auto",
               "NAME");
}

void add_crop(CLI::App& verb, Arguments& arguments) {
    add_option(verb, "--crop", arguments.crop, "This part of the picture alone, half-open", "X0,Y0,X1,Y1");
}

SceneDescription scene_of(const Arguments& arguments, const Options& options) {
    if (arguments.scene.empty())
        throw InputError("which scene? Name a TOML file; `kagero list scenes` shows those that came along");
    return load_scene(arguments.scene, overrides_of(arguments), catalogue(options.isa));
}

SceneDescription general_scene_of(Arguments arguments, const Options& options) {
    SceneDescription scene = scene_of(arguments, options);
    arguments.overrides.insert(arguments.overrides.begin(), "integrator.symmetry=none");
    try {
        return scene_of(arguments, options);
    } catch (const InputError&) {  // what was right before is wrong for one reason alone
        return scene;
    }
}

Options options_of(const Arguments& arguments) {
    Options options;
    if (const Said isa("--isa", arguments.isa, "KAGERO_ISA"); !isa.text.empty()) {
        options.isa = isa.text;
        if (!arguments.several_isas) require_isa(isa.by, isa.text);
        else if (isa.text != "all")
            for (const std::string& one : split(isa.text, ',')) require_isa(isa.by, one);
    }
    require_one_of("--strategy", arguments.strategy, {"auto", "scalar", "per-ray", "packet"});
    options.strategy = strategy_named(arguments.strategy);
    require_one_of("--precision", arguments.precision, {"auto", "double", "float"});
    options.precision = precision_named(arguments.precision);
    std::vector<std::string> schedules = schedule_names();
    schedules.insert(schedules.begin(), "auto");
    require_one_of("--schedule", arguments.schedule, schedules);
    options.schedule = schedule_named(arguments.schedule);
    if (const Said threads("--threads", arguments.threads, "KAGERO_THREADS"); !threads.text.empty())
        options.threads = count_of(threads.by, threads.text, most_threads);
    if (!arguments.crop.empty()) {
        const auto edges = whole_numbers("--crop", arguments.crop, ',', 4);
        if (edges[0] >= edges[2] || edges[1] >= edges[3])
            throw InputError("--crop: '" + arguments.crop + "' is empty; x0,y0,x1,y1 needs x0 < x1 and y0 < y1");
        options.crop = {edges[0], edges[1], edges[2], edges[3]};
    }
    return options;
}

void check_inside(const std::string& option, const std::string& given, const FilmDescription& film, std::uint32_t x,
                  std::uint32_t y) {
    if (x >= film.width || y >= film.height)
        throw InputError(option + ": " + given + " lies outside the film of " + std::to_string(film.width) + "x" +
                         std::to_string(film.height) + "; pixels count from 0");
}

void check_crop(const Arguments& arguments, const Options& options, const FilmDescription& film) {
    if (!arguments.crop.empty()) check_inside("--crop", arguments.crop, film, options.crop.x1 - 1, options.crop.y1 - 1);
}

std::vector<std::string> split(const std::string& text, char separator) {
    std::vector<std::string> parts(1);
    for (const char c : text) {
        if (c == separator)
            parts.emplace_back();
        else
            parts.back() += c;
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
        throw InputError(option + ": '" + text + "' is not " + std::to_string(count) + " whole numbers separated by '" +
                         separator + "'");
    return numbers;
}

std::uint32_t count_of(const std::string& option, const std::string& text, std::uint32_t most) {
    const auto number = parsed<std::uint32_t>(text);
    if (!number || *number < 1 || *number > most)
        throw InputError(option + ": '" + text + "' is " + (number ? "out of range" : "not a whole number") +
                         "; legal is 1 to " + std::to_string(most));
    return *number;
}

double finite_number(const std::string& option, const std::string& text) {
    const auto number = parsed<double>(text);
    if (!number || !std::isfinite(*number)) throw InputError(option + ": '" + text + "' is not a finite number");
    return *number;
}

void require_one_of(const std::string& option, const std::string& word, const std::vector<std::string>& known) {
    if (std::find(known.begin(), known.end(), word) != known.end()) return;
    throw InputError(option + ": there is no \"" + word + "\"" + suggestion(word, known));
}

bool json_took_word(const std::string& json, const std::vector<std::string>& known, const std::string& kind) {
    if (std::find(known.begin(), known.end(), json) != known.end()) return true;
    const std::string near = json.find_first_of("./") == std::string::npos ? near_match(json, known) : "";
    if (!near.empty())
        throw InputError("--json: \"" + json + "\" is neither a file's name nor " + kind + "; did you mean " + near +
                         "?");
    return false;
}

}  // namespace kagero
