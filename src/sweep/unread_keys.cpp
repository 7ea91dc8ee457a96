#include "sweep/unread_keys.h"

#include "scene/overrides.h"

#include <algorithm>

namespace kagero {
namespace {

/// The plan of a sweep, and its keys as paths.
struct SweptPlan {
    const Plan& plan;
    std::vector<std::vector<std::string>> paths;

    /// Returns true if a space is a formula. The bound on its steps depends on trial rays of the camera.
    bool has_formula() const {
        const SceneDescription& scene = plan.description();
        return scene.space.formula || std::any_of(scene.media.begin(), scene.media.end(),
                                                  [](const auto& medium) { return medium.space.formula.has_value(); });
    }
    /// Returns true if rays continue at surfaces, whose paints are then factors of their light.
    bool follows_paths() const { return plan.run.max_bounces > 0; }
    /// Returns true if all sets have the method of the plan, and no medium has another one.
    bool has_one_method() const {
        const std::vector<std::string> method{"integrator", "method"};
        return plan.description().media.empty() && std::find(paths.begin(), paths.end(), method) == paths.end();
    }
};

/// Keys that cannot change the ends of rays under a condition.
struct UnreadKeys {
    const char* table;              ///< First part of the path of the keys.
    std::size_t part;               ///< Number of the part of the path that `keys` contains, from 0.
    std::vector<std::string> keys;  ///< Empty: all keys of the table.
    const char* reason;
    bool (*is_true)(const SweptPlan&);  ///< The condition.
};

// Each row states keys, the reason and the condition. A key that is in no row may change the ends of rays.
const std::vector<UnreadKeys>& unread_keys() {
    static const auto always = [](const SweptPlan&) { return true; };
    static const auto without_formula = [](const SweptPlan& swept) { return !swept.has_formula(); };
    static const auto without_paths = [](const SweptPlan& swept) { return !swept.follows_paths(); };
    static const std::vector<UnreadKeys> rows{
        {"camera",
         1,
         {"type", "position", "look_at", "up", "fov", "height", "observer", "velocity", "shutter", "aperture_radius",
          "focus_distance"},
         "rays of a list do not start at the camera",
         without_formula},
        {"film", 1, {"size", "spp"}, "rays of a list have no pixels", without_formula},
        {"film",
         1,
         {"layers", "exposure", "tone", "sampling", "max_interpolation_error"},
         "rays of a list have no pixels",
         always},
        {"film", 1, {"seed", "max_bounces"}, "rays of a list end at the first surface", without_paths},
        {"sky", 1, {}, "rays end before the sky gives them a colour", always},
        {"animation", 1, {"frames", "fps"}, "rays of a list see frame 0, for which this key changes nothing", always},
        {"object",
         2,
         {"color", "texture", "checker", "faces", "shading", "temperature", "emission_strength", "tint"},
         "rays of a list have no colours",
         without_paths},
        {"integrator", 1, {"max_pixel_error"}, "it selects the method and the step of pictures only", always},
        {"integrator", 1, {"lanes", "refill", "cull"}, "it changes only the time of the rays", always},
        {"integrator",
         1,
         {"tolerance"},
         "the steps of the method do not depend on a tolerance",
         [](const SweptPlan& swept) { return swept.has_one_method() && !swept.plan.method().adaptive; }},
        {"integrator",
         1,
         {"solver_tolerance"},
         "the method solves no implicit equations",
         [](const SweptPlan& swept) { return swept.has_one_method() && !swept.plan.method().implicit; }},
    };
    return rows;
}

/// Returns true if a row contains the key with this path.
bool has_key(const UnreadKeys& row, const std::vector<std::string>& path) {
    if (path.size() <= row.part || path.front() != row.table) return false;
    return row.keys.empty() || std::find(row.keys.begin(), row.keys.end(), path[row.part]) != row.keys.end();
}

}  // namespace

std::vector<std::string> remarks_on_unread_keys(const Plan& plan, const std::vector<std::string>& keys) {
    SweptPlan swept{plan, {}};
    for (const std::string& key : keys) swept.paths.push_back(keys_of_path(key, {}));
    std::vector<std::string> remarks;
    for (std::size_t i = 0; i < keys.size(); ++i)
        for (const UnreadKeys& row : unread_keys())
            if (has_key(row, swept.paths[i]) && row.is_true(swept))
                remarks.push_back(keys[i].substr(0, keys[i].find('=')) + " has no effect on this sweep: " + row.reason +
                                  "; leave the key out");
    return remarks;
}

}  // namespace kagero
