/// The output of `kagero list`: Hamiltonians, integrators, strategies, instruction sets, scenes and layers.
#pragma once

#include <string>
#include <vector>

namespace kagero {

/// Returns the topics of `list` in the order of the output.
const std::vector<std::string>& list_topics();

/// Returns JSON with one array per topic. Hamiltonians, integrators and strategies are those of the kernel module for
/// `isa`. Scenes are the TOML files in `scene_directory`.
std::string listing_json(const std::vector<std::string>& topics, const std::string& isa,
                         const std::string& scene_directory);

/// Returns the same content as indented text.
std::string listing_text(const std::vector<std::string>& topics, const std::string& isa,
                         const std::string& scene_directory);

/// Returns the directory of the scenes that are distributed with the program, in the installation or in the source
/// tree. Returns "" if neither exists.
std::string find_scene_directory();

}  // namespace kagero
