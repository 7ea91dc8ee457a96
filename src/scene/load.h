/// The parts of load_scene, one function per table of the scene file.
#pragma once

#include "scene/reader.h"

namespace kagero {

SpaceDescription load_space(const Section& section, const Catalogue& catalogue);
/// An expression for `rescale` goes to the formula of the space.
IntegratorDescription load_integrator(const Section& section, SpaceDescription& space, const Catalogue& catalogue);
CameraDescription load_camera(const Section& section);
FilmDescription load_film(const Section& section, const std::vector<std::string>& layers);
/// [sky], beside which a table `far` may stand, or that table itself.
SkyDescription load_sky(const Section& section, const std::string& directory);
SkyDescription load_far_sky(const Section& sky, const SpaceDescription& space, const std::string& directory);

/// How `checker` is written: how many squares along u and v, or just `true`.
enum class CheckerKey { counts, flag };
/// The keys color, texture and checker; `fallback` where none of them is there.
Paint load_paint(const Section& section, const Paint& fallback, CheckerKey checker, const std::string& directory);

/// All [[object]] tables of a document.
std::vector<ObjectDescription> load_objects(const Value& root, const std::string& directory);

}  // namespace kagero
