/// Plans of lists of rays, which the verb `trace`, the public library and the Python module share.
#pragma once

#include "plan/plan.h"

#include <functional>
#include <string>
#include <vector>

namespace kagero {

/// Greatest number of surfaces through which the rays of a list can continue.
inline constexpr std::uint32_t max_ray_bounces = 1000;

/// Reads a scene with overrides KEY=VALUE: `first` comes before those that the user has stated, `last` after them.
using ReadScene =
    std::function<SceneDescription(const std::vector<std::string>& first, const std::vector<std::string>& last)>;

/// Reads a scene with integrator.symmetry = "none", so that rays follow the general path. If the scene states a method
/// that needs the orbit plane, the scene is read without this change. `last` contains further overrides.
SceneDescription general_path_scene(const ReadScene& read, const std::vector<std::string>& last = {});

/// Reads a scene for a list of rays. If rays end at a value of λ, which is the parameter of Hamilton's equations for H,
/// the scene has the general path and no time rescaling; this also selects the default method and step for H itself.
SceneDescription ray_list_scene(const ReadScene& read, bool has_parameter_limit);

/// Throws InputError if the options of a list of rays are out of range or exclude each other. `prefix` is written in
/// front of the names of options: "--" for the command line.
void check_ray_list(const Options& options, const std::string& prefix);

/// Returns the plan of a list of rays in a scene of ray_list_scene. Throws InputError if scene and options cannot be
/// used. For `prefix`, see check_ray_list.
Plan resolve_ray_list(SceneDescription scene, Options options, const std::string& prefix);

}  // namespace kagero
