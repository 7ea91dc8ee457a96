/// Loads the tables that describe a space: [space] and [[medium]].
#pragma once

#include "scene/reader.h"

namespace kagero {

/// The table of a space. A medium has a name and its own integrator, but no sky.
enum class SpaceTable { space, medium };

/// Returns the value of a parameter of a Hamiltonian. Throws InputError if it is not legal. `name` is its full name.
double to_parameter(const Value& value, const std::string& name, const ParameterInfo& parameter);

/// Loads the Hamiltonian of a space, with its parameters or formulas.
SpaceDescription load_space(const Section& section, const Catalogue& catalogue, SpaceTable table);

/// Loads all [[medium]] tables of a scene file, each with its table [medium.integrator]. `scene` contains the tables
/// [space] and [integrator].
std::vector<MediumDescription> load_media(const Value& root, const SceneDescription& scene, const Catalogue& catalogue);

/// Returns "space" and the names of the media, in the order of their indices.
std::vector<std::string> names_of_media(const std::vector<MediumDescription>& media);

}  // namespace kagero
