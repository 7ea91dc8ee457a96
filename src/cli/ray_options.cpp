#include "cli/ray_options.h"

#include "error.h"
#include "plan/names.h"
#include "report/csv/read_rays.h"

#include <filesystem>
#include <fstream>
#include <iostream>

namespace kagero {
namespace {

constexpr std::uint32_t max_values = 10'000'000;

/// Returns the values of --vary behind the sign '='.
std::vector<double> values_of_sweep(const std::string& option, const std::string& text) {
    std::vector<double> values;
    const std::vector<std::string> bounds = split(text, ':');
    if (bounds.size() == 1) {
        for (const std::string& value : split(text, ',')) values.push_back(finite_number(option, value));
        return values;
    }
    if (bounds.size() != 3) throw InputError(option + ": '" + text + "' is neither a list V1,V2,... nor a range A:B:N");
    const double first = finite_number(option, bounds[0]), last = finite_number(option, bounds[1]);
    const std::uint32_t count = count_of(option + ", the number of values", bounds[2], max_values, 2);
    for (std::uint32_t i = 0; i < count; ++i) {
        const double u = double(i) / (count - 1);
        values.push_back((1 - u) * first + u * last);
    }
    return values;
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

void add_swept_keys(CLI::App& verb, Arguments& arguments) {
    add_option(verb, "--vary", arguments.varied,
               "A key and its values: KEY=V1,V2,... or KEY=A:B:N for N values at equal distances from A to B, for "
               "example --vary space.rg=0:0.2:100. The option may be repeated; set number i consists of value i of "
               "every key",
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
        const std::string key = text.substr(0, sign);
        keys.push_back({key, values_of_sweep("--vary " + key, text.substr(sign + 1))});
    }
    return keys;
}

}  // namespace kagero
