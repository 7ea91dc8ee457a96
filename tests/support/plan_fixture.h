/// Plans for tests, made from the text or the file of a scene in the same way as the program makes them.
#pragma once

#include "accuracy/end_errors.h"
#include "appearance/redshift.h"
#include "film/write_film.h"
#include "modules/modules.h"
#include "plan/names.h"
#include "rays/camera.h"
#include "rays/start_rays.h"
#include "render/trace.h"
#include "scene/load/load.h"

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace kagero {
inline std::ostream& operator<<(std::ostream& out, const Override& key) { return out << key.text; }
}  // namespace kagero

namespace kagero::test {

using Overrides = std::vector<Override>;

/// Returns the plan of a scene file, for a picture or, if `with_camera` is false, for a list of rays.
inline std::unique_ptr<Plan> plan_of_file(const std::string& path, const Overrides& overrides,
                                          const Options& options = {}, bool with_camera = true) {
    const Purpose purpose = with_camera ? Purpose::picture : Purpose::ray_list;
    return std::make_unique<Plan>(make_plan(load_scene(path, overrides, catalogue(options.isa)), options, purpose));
}

/// Return the path and the text of a scene in the folder scenes/.
inline std::string scene_file(const std::string& name) { return std::string(KAGERO_SCENES "/") + name; }
inline std::string scene_text(const std::string& name) {
    std::ifstream file(scene_file(name));
    return {std::istreambuf_iterator<char>(file), {}};
}

/// Returns the plan of a scene that is given as text. The text is written to a temporary file, which is removed again.
inline std::unique_ptr<Plan> plan_of_text(const std::string& text, const Overrides& overrides,
                                          const Options& options = {}, bool with_camera = true) {
    const auto path = std::filesystem::temp_directory_path() / ("kagero-scene-" + std::to_string(::getpid()) + ".toml");
    std::ofstream(path) << text;
    auto plan = plan_of_file(path.string(), overrides, options, with_camera);
    std::filesystem::remove(path);
    return plan;
}

/// Returns the observer with the given name, or no value if the name is empty. Without an observer, directions of rays
/// are directions in coordinates.
inline std::optional<ObserverKind> observer_of(const std::string& name) {
    if (name.empty()) return {};
    return observer_named(name);
}

/// Returns the redshift of a ray of the plan's camera.
inline double redshift_of(const Plan& plan, const PixelSample& ray) {
    return kagero::redshift_of(plan.scene->sources, plan.view.spacetime, ray);
}

/// Returns the names of the instruction sets for which modules were built and which this machine supports.
inline std::vector<std::string> supported_isas() {
    std::vector<std::string> names;
    for (const IsaInfo& isa : find_isas())
        if (isa.supported) names.push_back(isa.name);
    return names;
}

/// Returns options for one thread and the given strategy, "scalar" or "packet". With these options the ends of listed
/// rays contain λ.
inline Options with_strategy(const std::string& strategy) {
    Options options;
    options.parameter = true;
    options.strategy = strategy_named(strategy);
    options.threads = 1;
    return options;
}

}  // namespace kagero::test
