/// Loads the tables of objects, and the paints of objects and skies.
#pragma once

#include "scene/reader.h"

namespace kagero {

/// The type of the key `checker`: for an object, two numbers of squares, along u and along v; for a sky, true or false.
enum class CheckerKey { counts, flag };
/// Loads the keys color, texture and checker. Returns `default_paint` if all three are missing. Relative paths of
/// textures start at `directory`.
Paint load_paint(const Section& section, const Paint& default_paint, CheckerKey checker_key,
                 const std::string& directory);

/// Loads all [[object]] tables of a scene file. Relative paths start at `directory`. Formulas of objects may use the
/// names of the space, which are then recorded as used. Boundaries refer to `media` by name.
std::vector<ObjectDescription> load_objects(const Value& root, const std::string& directory, SpaceDescription& space,
                                            const std::vector<MediumDescription>& media);

}  // namespace kagero
