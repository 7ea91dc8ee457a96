// Fuzz target for the readers of mesh files: any bytes must be read as a mesh or refused by an InputError. The
// beginning of the input selects the format. The mesh must be consistent: finite vertices, and indices in range.
#include "geometry/files/gltf/gltf.h"
#include "geometry/files/obj/obj.h"
#include "geometry/files/ply/header.h"
#include "geometry/files/ply/ply.h"
#include "target.h"

#include <algorithm>
#include <cmath>
#include <string>

const char* const fuzz_words =
    "v vt vn f l p o g s usemtl mtllib surf curv # \\ \\\n \r \r\n \xef\xbb\xbf \xff\xfe 1/1/1 1//1 -1 0 1e400 nan "
    "-inf +1 "
    ".5 1. ply format ascii binary_little_endian binary_big_endian 1.0 element vertex face tristrips edge property "
    "list "
    "char uchar short ushort int uint float double x y z nx ny nz s t texcoord vertex_indices vertex_index end_header "
    "comment obj_info \nelement \nproperty \nend_header\n glTF JSON { } [ ] : , \"asset\" \"version\" \"2.0\" "
    "\"scene\" "
    "\"scenes\" \"nodes\" \"mesh\" \"meshes\" \"primitives\" \"attributes\" \"POSITION\" \"NORMAL\" \"TEXCOORD_0\" "
    "\"indices\" \"mode\" \"accessors\" \"bufferView\" \"bufferViews\" \"buffer\" \"buffers\" \"byteOffset\" "
    "\"byteLength\" "
    "\"byteStride\" \"componentType\" \"count\" \"type\" \"SCALAR\" \"VEC2\" \"VEC3\" \"normalized\" true \"sparse\" "
    "\"values\" "
    "\"children\" \"matrix\" \"rotation\" \"scale\" \"translation\" \"extensionsRequired\" \"KHR_mesh_quantization\" "
    "5120 5121 "
    "5122 5123 5125 5126 65535 4294967295 2147483648 9007199254740992";

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace kagero;
    const MeshSource source{"mesh", {reinterpret_cast<const char*>(data), size}, "scene"};
    const bool is_gltf = source.bytes.starts_with("glTF") || source.bytes.starts_with('{');
    try {
        const FileMesh mesh = is_gltf ? read_gltf(source) : is_ply(source) ? read_ply(source) : read_obj(source);
        const std::size_t vertices = mesh.vertices.size() / 3;
        const bool is_consistent =
            mesh.vertices.size() == 3 * vertices && mesh.normals.size() == 3 * vertices &&
            mesh.uv.size() == 2 * vertices && mesh.triangles.size() % 3 == 0 &&
            std::all_of(mesh.vertices.begin(), mesh.vertices.end(), [](double x) { return std::isfinite(x); }) &&
            std::all_of(mesh.uv.begin(), mesh.uv.end(), [](double x) { return std::isfinite(x); }) &&
            std::all_of(mesh.triangles.begin(), mesh.triangles.end(), [&](std::uint32_t i) { return i < vertices; });
        if (!is_consistent) __builtin_trap();
        return mesh.triangles.empty() ? -1 : 0;  // load_mesh refuses a mesh without triangles
    } catch (const InputError&) {
        return -1;
    }
}
