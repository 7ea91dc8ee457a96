#include "geometry/embree.h"

#include "scene/vector3.h"

#include <algorithm>

namespace kagero {

namespace {

float to_embree(double q, double shift, double scale) {
    return static_cast<float>((q - shift) * scale);
}

/// Throws RunError if Embree has reported an error. `action` describes the failed action in the message, such as
/// "building the scene".
void throw_on_error(RTCDevice device, const char* action) {
    const RTCError error = rtcGetDeviceError(device);
    if (error != RTC_ERROR_NONE)
        throw RunError(std::string("Embree failed while ") + action + ": RTCError " + std::to_string(error) +
                       " (4 means out of memory, 5 an unsupported processor)");
}

/// Distance in Embree's coordinates by which triangles are enlarged. It is several times the rounding error of a query,
/// so that no hit is missed; kernels reject hits outside of the exact triangles.
constexpr double enlargement = 2e-6;

/// Writes the corners of a triangle, moved away from its centre such that each edge moves outward by `enlargement`. A
/// triangle much narrower than this distance is enlarged at most 16 times.
void write_enlarged(const Surface& surface, const std::uint32_t* index, const double shift[3], const Double3& scale,
                    float* corners) {
    Double3 corner[3], center{};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t k = 0; k < 3; ++k) {
            corner[i][k] = (surface.vertices[3 * std::size_t{index[i]} + k] - shift[k]) * scale[k];
            center[k] += corner[i][k] / 3;
        }
    const Double3 ab = subtract(corner[1], corner[0]), ac = subtract(corner[2], corner[0]);
    const double perimeter = length(ab) + length(ac) + length(subtract(corner[2], corner[1]));
    const double inner_radius = length(cross(ab, ac)) / perimeter;
    const double factor = 1 + std::min(15.0, enlargement / std::max(inner_radius, 1e-300));
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t k = 0; k < 3; ++k)
            corners[3 * i + k] = static_cast<float>(center[k] + factor * (corner[i][k] - center[k]));
}

RTCGeometry triangles_geometry(RTCDevice device, const Surface& surface, std::size_t triangles, const double shift[3],
                               const Double3& scale) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* points = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                               3 * sizeof(float), 3 * triangles));
    auto* indices =
        static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                            3 * sizeof(std::uint32_t), triangles));
    if (points && indices)
        for (std::size_t i = 0; i < triangles; ++i) {
            write_enlarged(surface, surface.triangles + 3 * i, shift, scale, points + 9 * i);
            for (std::size_t k = 0; k < 3; ++k) indices[3 * i + k] = static_cast<std::uint32_t>(3 * i + k);
        }
    return geometry;
}

/// Intersection filter for rings: rejects hits that are not between the radii of the ring. Embree then searches for
/// hits farther along the ray.
void filter_ring_hits(const RTCFilterFunctionNArguments* arguments) {
    const auto& ring = *static_cast<const EmbreeScene::FloatRing*>(arguments->geometryUserPtr);
    RTCRayN* ray = arguments->ray;
    const unsigned n = arguments->N;
    for (unsigned i = 0; i < n; ++i) {
        if (arguments->valid[i] == 0) continue;
        const float t = RTCRayN_tfar(ray, n, i);
        const float x = RTCRayN_org_x(ray, n, i) + t * RTCRayN_dir_x(ray, n, i) - ring.center[0];
        const float y = RTCRayN_org_y(ray, n, i) + t * RTCRayN_dir_y(ray, n, i) - ring.center[1];
        const float z = RTCRayN_org_z(ray, n, i) + t * RTCRayN_dir_z(ray, n, i) - ring.center[2];
        const float r2 = x * x + y * y + z * z;
        if (r2 < ring.inner_squared || r2 > ring.outer_squared) arguments->valid[i] = 0;
    }
}

}  // namespace

void EmbreeScene::attach_rings(const std::vector<Ring>& rings, const double shift[3], double scale) {
    rings_.reserve(rings.size());  // Embree stores pointers to the elements
    for (const Ring& ring : rings) {
        FloatRing& float_ring = rings_.emplace_back();
        for (std::size_t i = 0; i < 3; ++i) float_ring.center[i] = to_embree(ring.center[i], shift[i], scale);
        float_ring.inner_squared = static_cast<float>(ring.inner * ring.inner * scale * scale);
        float_ring.outer_squared = static_cast<float>(ring.outer * ring.outer * scale * scale);
        RTCGeometry geometry = rtcGetGeometry(scene_, ring.surface);
        rtcSetGeometryUserData(geometry, &float_ring);
        rtcSetGeometryIntersectFilterFunction(geometry, filter_ring_hits);
        rtcCommitGeometry(geometry);
    }
}

EmbreeScene::EmbreeScene(const std::vector<Surface>& surfaces, const std::vector<std::size_t>& triangle_counts,
                         const std::vector<Ring>& rings, const double shift[3], const Double3& scale) {
    // The configuration string is empty: "threads=" in it would limit TBB for the whole program.
    device_ = rtcNewDevice("");
    if (!device_) throw_on_error(nullptr, "creating a device");
    if (!device_) throw RunError("Embree returned neither a device nor an error code");
    try {
        scene_ = rtcNewScene(device_);
        rtcSetSceneFlags(scene_, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | KAGERO_EMBREE_QUERY_FILTER));
        rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
        spheres_.reserve(surfaces.size());  // Embree stores pointers to the elements
        for (std::size_t i = 0; i < surfaces.size(); ++i) {
            RTCGeometry geometry;
            if (surfaces[i].kind == Surface::Kind::sphere)
                geometry = sphere_geometry(
                    device_, spheres_.emplace_back(surfaces[i], std::array{shift[0], shift[1], shift[2]}, scale[0]));
            else geometry = triangles_geometry(device_, surfaces[i], triangle_counts[i], shift, scale);
            rtcSetGeometryMask(geometry, 0xffffffffu);
            rtcCommitGeometry(geometry);
            rtcAttachGeometryByID(scene_, geometry, static_cast<unsigned>(i));
            rtcReleaseGeometry(geometry);
            throw_on_error(device_, "building a geometry");
        }
        attach_rings(rings, shift, scale[0]);
        rtcCommitScene(scene_);
        throw_on_error(device_, "building the scene");
    } catch (...) {
        if (scene_) rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
        throw;
    }
}

EmbreeScene::~EmbreeScene() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
}

}  // namespace kagero
