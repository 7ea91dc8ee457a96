#include "cli/ray_options.h"

#include "error.h"
#include "plan/names.h"
#include "report/csv/read_rays.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>

namespace kagero {
namespace {

constexpr std::uint32_t max_values = 10'000'000;

/// Returns the values of a list V1,V2,..., which may contain strings in quotes, arrays in brackets, and formulas with
/// functions of several arguments.
std::vector<std::string> split_values(const std::string& text) {
    std::vector<std::string> values(1);
    int depth = 0;
    char quote = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (c == ',' && depth == 0 && !quote) {
            values.emplace_back();
            continue;
        }
        values.back() += c;
        if (quote && c == '\\' && quote == '"' && i + 1 < text.size()) values.back() += text[++i];
        else if (quote) quote = c == quote ? 0 : quote;
        else if (c == '"' || c == '\'') quote = c;
        else if (c == '[' || c == '{' || c == '(') ++depth;
        else if (c == ']' || c == '}' || c == ')') --depth;
    }
    return values;
}

/// Returns the numbers of a range A:B:N.
std::vector<double> values_of_range(const std::string& option, const std::vector<std::string>& bounds) {
    const double first = finite_number(option, bounds[0]), last = finite_number(option, bounds[1]);
    const std::uint32_t count = count_of(option + ", the number of values", bounds[2], max_values, 2);
    std::vector<double> values;
    for (std::uint32_t i = 0; i < count; ++i) {
        const double u = double(i) / (count - 1);
        values.push_back((1 - u) * first + u * last);
    }
    return values;
}

/// Returns true if a text begins as a number.
bool begins_as_number(const std::string& text) {
    return text.find_first_of("0123456789") <= text.find_first_not_of("+-.");
}

/// Returns true if a value of --vary is meant as a number, possibly with a mistake. A text with an operator of
/// formulas, such as 2*x or 1+x, is not.
bool is_number(const std::string& value) {
    if (value == "nan" || value == "inf") return true;
    const std::size_t sign = value.find_first_of("+-", 1);
    const bool has_sum = sign != std::string::npos && value[sign - 1] != 'e' && value[sign - 1] != 'E';
    return begins_as_number(value) && !has_sum && value.find_first_of("*/^(") == std::string::npos;
}

/// Returns the key with its values, which are the text of --vary behind the sign '='.
SweptKey key_with_values(const std::string& key, const std::string& text) {
    const std::string option = "--vary " + key;
    const std::vector<std::string> values = split_values(text);
    if (values.size() == 1 && begins_as_number(text) && text.find(':') != std::string::npos) {
        const std::vector<std::string> bounds = split(text, ':');
        if (bounds.size() != 3)
            throw InputError(option + ": '" + text + "' is neither a list V1,V2,... nor a range A:B:N");
        return {key, values_of_range(option, bounds)};
    }
    SweptKey swept{key, {}};
    const bool are_numbers = std::all_of(values.begin(), values.end(), is_number);
    for (const std::string& value : values) {
        if (value.empty()) throw InputError(option + ": '" + text + "' contains an empty value; write KEY=V1,V2,...");
        if (are_numbers) swept.values.push_back(finite_number(option, value));
        else swept.texts.push_back(value);
    }
    return swept;
}

}  // namespace

void add_ray_options(CLI::App& verb, Arguments& arguments) {
    add_option(verb, "--rays", arguments.rays,
               "CSV of rays with the columns x,y,z,dx,dy,dz in any order: start and direction of each ray; '-' is "
               "stdin. Default: -",
               "FILE");
    add_option(verb, "--observer", arguments.observer,
               "Observer in whose rest frame directions are given: static, zamo, falling or coordinate. Default: none; "
               "directions are dq/dλ in scene coordinates",
               "NAME");
}

std::vector<RayInput> rays_of(const Arguments& arguments) {
    if (arguments.rays == "-") return read_rays(std::cin, "stdin");
    std::error_code ignored;
    if (std::filesystem::is_directory(arguments.rays, ignored))
        throw InputError("cannot read the rays '" + arguments.rays + "': it is a directory");
    std::ifstream in(arguments.rays, std::ios::binary);
    if (!in)
        throw InputError("cannot read the rays '" + arguments.rays + "': the file does not exist or is not readable");
    return read_rays(in, arguments.rays);
}

std::optional<ObserverKind> observer_of(const Arguments& arguments) {
    if (arguments.observer.empty()) return {};
    return observer_named(arguments.observer);
}

ReadScene scene_reader(const Arguments& arguments, const Options& options) {
    return [=](const std::vector<std::string>& first, const std::vector<std::string>& last) {
        Arguments changed = arguments;
        changed.overrides.insert(changed.overrides.begin(), first.begin(), first.end());
        changed.overrides.insert(changed.overrides.end(), last.begin(), last.end());
        return scene_of(changed, options, SceneUse::single_rays);
    };
}

void add_swept_keys(CLI::App& verb, Arguments& arguments) {
    add_option(verb, "--vary", arguments.varied,
               "A key and its values: KEY=V1,V2,... with values as for -D, or KEY=A:B:N for N numbers at equal "
               "distances from A to B, for example --vary space.rg=0:0.2:100. The option may be repeated; set number i "
               "consists of value i of every key",
               "KEY=VALUES");
}

std::vector<SweptKey> keys_of_sweep(const Arguments& arguments) {
    if (arguments.varied.empty())
        throw InputError("a sweep needs a key and its values; add, for example, --vary space.rg=0:0.2:100");
    std::vector<SweptKey> keys;
    for (const std::string& text : arguments.varied) {
        const std::size_t sign = text.find('=');
        if (sign == std::string::npos || sign == 0)
            throw InputError("--vary: '" + text + "' is not KEY=VALUES, such as space.rg=0,0.1 or space.rg=0:0.2:100");
        keys.push_back(key_with_values(text.substr(0, sign), text.substr(sign + 1)));
    }
    return keys;
}

}  // namespace kagero
