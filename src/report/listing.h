/// What can be chosen, as `list` shows it.
#pragma once

#include <string>
#include <vector>

namespace kagero {

/// Topics of `list`, in the order they are shown.
const std::vector<std::string>& list_topics();

/// JSON with one array per topic. `isa` names the module that Hamiltonians, integrators and strategies are taken from;
/// scenes are the files of `scene_directory`.
std::string listing_json(const std::vector<std::string>& topics, const std::string& isa,
                         const std::string& scene_directory);

/// The same for people.
std::string listing_text(const std::vector<std::string>& topics, const std::string& isa,
                         const std::string& scene_directory);

/// The scenes that came with the program: beside its build, or installed. Empty when there are none.
std::string find_scene_directory();

}  // namespace kagero
