#include "scene/sky_only.h"

namespace kagero {

bool shows_only_sky(const SceneDescription& scene) { return why_not_only_sky(scene).empty(); }

std::string why_not_only_sky(const SceneDescription& scene) {
    if (!scene.objects.empty()) return "rays end on objects, at points that depend on the position of the camera";
    if (!scene.media.empty()) return "the scene has media";
    if (scene.camera.type != CameraType::perspective) return "the camera is " + name_of(scene.camera.type);
    return "";
}

}  // namespace kagero
