#include "library/ray_list.h"

#include "error.h"
#include "scene/value.h"
#include "tuning/resolve.h"

#include <cmath>

namespace kagero {
namespace {

bool is_positive(double number) { return std::isfinite(number) && number > 0; }

}  // namespace

SceneDescription general_path_scene(const ReadScene& read, const std::vector<std::string>& last) {
    SceneDescription stated = read({}, last);
    try {
        return read({"integrator.symmetry=none"}, last);
    } catch (const InputError&) {  // The only possible reason is a method that excludes symmetry = "none".
        return stated;
    }
}

SceneDescription ray_list_scene(const ReadScene& read, bool has_parameter_limit) {
    if (!has_parameter_limit) return read({}, {});
    SceneDescription scene = general_path_scene(read);
    return scene.integrator.rescale == "auto" ? general_path_scene(read, {"integrator.rescale=none"}) : scene;
}

void check_ray_list(const Options& options, const std::string& prefix) {
    if (options.bounces.value_or(0) > max_ray_bounces)
        throw InputError(prefix + "bounces: " + std::to_string(*options.bounces) +
                         " is out of range; it must be from 0 to " + std::to_string(max_ray_bounces));
    if (options.parameter_limit && !is_positive(*options.parameter_limit))
        throw InputError(prefix + "parameter: " + to_toml(*options.parameter_limit) +
                         " is not a finite number greater than 0, the value at the start of a ray");
    if (options.parameter_limit && options.bounces)
        throw InputError(prefix + "bounces and " + prefix +
                         "parameter exclude each other: each medium has its own ray parameter");
    if (options.path_interval && !is_positive(*options.path_interval))
        throw InputError(prefix + "every: " + to_toml(*options.path_interval) +
                         " is not a finite number greater than 0");
}

Plan resolve_ray_list(SceneDescription scene, Options options, const std::string& prefix) {
    check_ray_list(options, prefix);
    const std::string cannot_end = prefix + "parameter: rays cannot end at a value of the ray parameter";
    if (options.parameter_limit && scene.integrator.rescale != "none")
        throw InputError(cannot_end +
                         " while integrator.rescale replaces it by another integration parameter; set "
                         "integrator.rescale = \"none\"");
    if (options.bounces == 0U) options.bounces.reset();
    Plan plan = resolve(std::move(scene), options, Purpose::ray_list);
    if (options.parameter_limit && plan.method().angular)
        throw InputError(cannot_end + ", because integrator.method = \"" + std::string(plan.method().name) +
                         "\" steps in an angle; choose a method other than orbit-* and mino-*");
    if (options.parameter_limit) plan.run.parameter_limit = *options.parameter_limit;
    plan.run.path_interval = options.path_interval.value_or(0);
    return plan;
}

}  // namespace kagero
