#include "geometry/embree.h"

#include <cstring>

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

RTCGeometry triangles_geometry(RTCDevice device, const Surface& surface, std::size_t vertices, std::size_t triangles,
                               const double shift[3], const Double3& scale) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* points = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), vertices));
    auto* indices =
        static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                            3 * sizeof(std::uint32_t), triangles));
    if (points && indices) {
        for (std::size_t i = 0; i < 3 * vertices; ++i)
            points[i] = to_embree(surface.vertices[i], shift[i % 3], scale[i % 3]);
        std::memcpy(indices, surface.triangles, 3 * triangles * sizeof(std::uint32_t));
    }
    return geometry;
}

/// Creates a sphere. A ray that starts inside the sphere hits it where the ray leaves it (verified with Embree 3.13.5
/// for single rays and packets).
RTCGeometry sphere_geometry(RTCDevice device, const Surface& surface, const double shift[3], double scale) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
    auto* sphere = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, 4 * sizeof(float), 1));
    if (sphere) {
        for (std::size_t i = 0; i < 3; ++i) sphere[i] = to_embree(surface.center[i], shift[i], scale);
        sphere[3] = static_cast<float>(surface.radius * scale);
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

EmbreeScene::EmbreeScene(const std::vector<Surface>& surfaces, const std::vector<std::size_t>& vertex_counts,
                         const std::vector<std::size_t>& triangle_counts, const std::vector<Ring>& rings,
                         const double shift[3], const Double3& scale) {
    // The configuration string is empty: "threads=" in it would limit TBB for the whole program.
    device_ = rtcNewDevice("");
    if (!device_) throw_on_error(nullptr, "creating a device");
    if (!device_) throw RunError("Embree returned neither a device nor an error code");
    try {
        scene_ = rtcNewScene(device_);
        rtcSetSceneFlags(scene_, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | KAGERO_EMBREE_QUERY_FILTER));
        rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
        for (std::size_t i = 0; i < surfaces.size(); ++i) {
            const bool is_sphere = surfaces[i].kind == Surface::Kind::sphere;
            RTCGeometry geometry = is_sphere ? sphere_geometry(device_, surfaces[i], shift, scale[0])
                                             : triangles_geometry(device_, surfaces[i], vertex_counts[i],
                                                                  triangle_counts[i], shift, scale);
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
