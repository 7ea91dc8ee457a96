#include "geometry/files/gltf/gltf.h"

#include "geometry/files/gltf/accessor.h"
#include "geometry/files/gltf/materials.h"
#include "geometry/files/polygons.h"

#include <set>

namespace kagero {

namespace {

using nlohmann::json;

/// An affine transformation: the images of the three axes, and of the origin.
struct Transform {
    Double3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, origin{0, 0, 0};

    Double3 direction(const Double3& v) const { return add(add(scaled(x, v[0]), scaled(y, v[1])), scaled(z, v[2])); }
    Double3 point(const Double3& v) const { return add(direction(v), origin); }
};

/// Returns a normal transformed by the cofactor matrix of m. This matrix equals the transposed inverse up to a factor,
/// which is made positive here. It needs no division, so it stays finite for matrices of any scale. The result has unit
/// length, or is zero if the normal has no direction.
Double3 transformed_normal(const Transform& m, const Double3& normal) {
    const Double3 yz = cross(m.y, m.z);
    const Double3 transformed =
        add(add(scaled(yz, normal[0]), scaled(cross(m.z, m.x), normal[1])), scaled(cross(m.x, m.y), normal[2]));
    const double norm = std::hypot(transformed[0], transformed[1], transformed[2]);
    const double inverse = norm > 0 && std::isfinite(norm) ? 1 / norm : 0;
    return inverse > 0 ? scaled(transformed, dot(m.x, yz) < 0 ? -inverse : inverse) : Double3{};
}

/// State of a reader of a glTF file.
struct GltfReader {
    const GltfDocument& document;
    GltfBuffers buffers;
    FileMesh mesh{};
    std::set<std::uint64_t> visited{};  ///< Nodes that have been read.
    std::size_t skins = 0, morphed = 0, incomplete = 0, colored = 0;
    std::map<std::uint64_t, std::uint32_t> materials{};  ///< Index in `mesh` of the materials that have been read.
};

/// Returns the index in the mesh of the material of a primitive, which is read at its first use.
std::uint32_t material_of(GltfReader& gltf, const json& primitive, const std::string& name) {
    const json* value = find_member(gltf.document, primitive, "material", name);
    const std::uint64_t index = value ? index_of(gltf.document, *value, "materials", name + ".material") : no_default;
    const auto [found, is_new] = gltf.materials.emplace(index, std::uint32_t(gltf.mesh.materials.size()));
    if (is_new)
        gltf.mesh.materials.push_back(value ? read_gltf_material(gltf.document, gltf.buffers, index)
                                            : default_gltf_material());
    return found->second;
}

Double3 to_double3(const std::vector<double>& numbers, std::size_t first) {
    return {numbers[first], numbers[first + 1], numbers[first + 2]};
}

/// Returns the transformation of a node: its matrix (column by column), or translation × rotation × scale.
Transform local_transform(const GltfDocument& document, const json& node, const std::string& name) {
    const auto numbers = [&](const char* key, const std::vector<double>& missing) {
        const json* member = find_member(document, node, key, name);
        return member ? numbers_of(document, *member, missing.size(), name + '.' + key) : missing;
    };
    if (find_member(document, node, "matrix", name)) {
        const std::vector<double> m = numbers("matrix", std::vector<double>(16));
        return {to_double3(m, 0), to_double3(m, 4), to_double3(m, 8), to_double3(m, 12)};
    }
    const std::vector<double> t = numbers("translation", {0, 0, 0}), r = numbers("rotation", {0, 0, 0, 1}),
                              s = numbers("scale", {1, 1, 1});
    const double x = r[0], y = r[1], z = r[2], w = r[3];  // the unit quaternion w + xi + yj + zk
    return {scaled({1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)}, s[0]),
            scaled({2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)}, s[1]),
            scaled({2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)}, s[2]), to_double3(t, 0)};
}

/// Appends the vertices of a primitive and returns their number. `part` is the name of the mesh. `material` determines
/// the texture coordinates.
std::size_t append_vertices(GltfReader& gltf, const json& attributes, const Transform& to_scene,
                            const FileMaterial& material, const std::string& part, const std::string& name) {
    const auto numbers = [&](const char* key, GltfUse use) {
        const json* member = find_member(gltf.document, attributes, key, name);
        return member ? read_accessor(gltf.document, gltf.buffers, *member, use, name + '.' + key)
                      : std::vector<double>();
    };
    const std::vector<double> points = numbers("POSITION", GltfUse::positions);
    const std::vector<double> normals = numbers("NORMAL", GltfUse::normals);
    const std::vector<double> uv =
        numbers(("TEXCOORD_" + std::to_string(material.uv_set)).c_str(), GltfUse::texture_coordinates);
    const std::size_t count = points.size() / 3;
    if ((!normals.empty() && normals.size() / 3 != count) || (!uv.empty() && uv.size() / 2 != count))
        refuse_gltf(gltf.document.source,
                    name + " have different counts; POSITION has " + std::to_string(count) + " elements");
    check_number_of_vertices(gltf.document.source, gltf.mesh.vertices.size() / 3 + count);
    for (std::size_t i = 0; i < count; ++i) {
        const Double3 raw = to_double3(points, 3 * i), point = to_scene.point(raw);
        if (!is_finite(raw) || !is_finite(point))
            refuse_gltf(gltf.document.source, reason_not_finite(i, part, is_finite(raw) ? point : raw));
        const Double3 normal = normals.empty() ? Double3{} : transformed_normal(to_scene, to_double3(normals, 3 * i));
        double coordinates[2]{};
        if (!uv.empty()) {
            const auto [u, v] = material.uv_transform({uv[2 * i], uv[2 * i + 1]});
            coordinates[0] = u;
            coordinates[1] = 1 - v;  // v of glTF increases downward
        }
        if (!std::isfinite(coordinates[0]) || !std::isfinite(coordinates[1]))
            refuse_gltf(gltf.document.source, "the texture coordinates of vertex " + std::to_string(i) + " of part " +
                                                  in_quotes(part) + " are not finite; they must be finite numbers");
        append_vertex(gltf.mesh, point, normals.empty() ? nullptr : normal.data(), uv.empty() ? nullptr : coordinates);
    }
    return count;
}

/// Returns the vertex indices of a primitive, relative to the mesh of the file. Without indices, a primitive uses its
/// vertices in order.
std::vector<std::uint32_t> corners_of(GltfReader& gltf, const json& primitive, std::size_t first, std::size_t count,
                                      const std::string& part, const std::string& name) {
    std::vector<std::uint32_t> corners;
    const json* indices = find_member(gltf.document, primitive, "indices", name);
    if (!indices) {
        for (std::size_t i = 0; i < count; ++i) corners.push_back(static_cast<std::uint32_t>(first + i));
        return corners;
    }
    for (const double index :
         read_accessor(gltf.document, gltf.buffers, *indices, GltfUse::indices, name + ".indices")) {
        if (index >= double(count))
            refuse_gltf(gltf.document.source, "face " + std::to_string(corners.size() / 3) + " of part " +
                                                  in_quotes(part) + " has the vertex index " + number_text(index) +
                                                  ", but its part has only " + std::to_string(count) + " vertices");
        corners.push_back(static_cast<std::uint32_t>(first) + static_cast<std::uint32_t>(index));
    }
    return corners;
}

void append_primitive(GltfReader& gltf, const json& primitive, const Transform& to_scene, const std::string& part,
                      const std::string& name) {
    const std::uint64_t mode = whole_number(gltf.document, primitive, "mode", name, 4);
    if (mode > 6)
        refuse_gltf(gltf.document.source,
                    name + ".mode = " + std::to_string(mode) + " is not legal; it must be 0 to 6");
    const json* attributes = find_member(gltf.document, primitive, "attributes", name);
    if (!attributes || !find_member(gltf.document, *attributes, "POSITION", name + ".attributes"))
        refuse_gltf(gltf.document.source, name +
                                              ".attributes has no POSITION, which is required; an extension that "
                                              "stores it elsewhere is not supported");
    const std::size_t first = gltf.mesh.vertices.size() / 3, without_uv = gltf.mesh.vertices_without_uv;
    const bool reads_materials = gltf.document.source.reads_materials && mode >= 4;
    const std::uint32_t material = reads_materials ? material_of(gltf, primitive, name) : 0;
    const FileMaterial& coordinates = reads_materials ? gltf.mesh.materials[material] : FileMaterial();
    const std::size_t count = append_vertices(gltf, *attributes, to_scene, coordinates, part, name + ".attributes");
    if (reads_materials && attributes->contains("COLOR_0")) ++gltf.colored;
    const std::vector<std::uint32_t> corners = corners_of(gltf, primitive, first, count, part, name);
    std::vector<std::uint32_t>& triangles = gltf.mesh.triangles;
    const std::size_t n = corners.size();
    if (mode == 4) {
        triangles.insert(triangles.end(), corners.begin(), corners.end() - static_cast<std::ptrdiff_t>(n % 3));
        if (n % 3 != 0) ++gltf.incomplete;
    } else if (mode == 5) {
        append_strip(gltf.mesh, corners.data(), n);
    } else if (mode == 6) {
        for (std::size_t i = 2; i < n; ++i) triangles.insert(triangles.end(), {corners[i - 1], corners[i], corners[0]});
    } else {
        const std::size_t parts[] = {n, n / 2, n, n - 1};  // of points, lines, a closed line and a line strip
        gltf.mesh.points_and_lines += parts[mode];
        gltf.mesh.vertices_without_uv = without_uv;
    }
    if (reads_materials) gltf.mesh.material_of_triangle.resize(triangles.size() / 3, material);
    if (!array_member(gltf.document, primitive, "targets", name).empty()) ++gltf.morphed;
}

void append_mesh(GltfReader& gltf, const json& value, const Transform& to_scene, const std::string& node_name) {
    const std::uint64_t index = index_of(gltf.document, value, "meshes", node_name + ".mesh");
    const std::string name = "meshes[" + std::to_string(index) + "]";
    const json& mesh = entry_of(gltf.document, "meshes", index);
    const json* stated = find_member(gltf.document, mesh, "name", name);
    const std::string part = stated && stated->is_string() ? stated->get<std::string>() : name;
    std::size_t i = 0;
    for (const json& primitive : array_member(gltf.document, mesh, "primitives", name))
        append_primitive(gltf, primitive, to_scene, part, name + ".primitives[" + std::to_string(i++) + "]");
}

/// Appends the meshes of a node and of its descendants. The recursion is as deep as the tree of nodes, which is at most
/// 1000 here.
void append_node(GltfReader& gltf, const json& value, const Transform& parent, const std::string& where) {
    const std::uint64_t index = index_of(gltf.document, value, "nodes", where);
    const std::string name = "nodes[" + std::to_string(index) + "]";
    if (!gltf.visited.insert(index).second)
        refuse_gltf(gltf.document.source, where + ": node " + std::to_string(index) + " occurs twice in the scene");
    const json& node = entry_of(gltf.document, "nodes", index);
    const Transform local = local_transform(gltf.document, node, name);
    const Transform to_scene{parent.direction(local.x), parent.direction(local.y), parent.direction(local.z),
                             parent.point(local.origin)};
    const json* mesh = find_member(gltf.document, node, "mesh", name);
    if (mesh) append_mesh(gltf, *mesh, to_scene, name);
    if (mesh && find_member(gltf.document, node, "skin", name)) ++gltf.skins;
    for (const json& child : array_member(gltf.document, node, "children", name))
        append_node(gltf, child, to_scene, name + ".children");
}

void append_remarks(GltfReader& gltf, std::size_t scenes, bool has_default) {
    const auto remark = [&](std::size_t count, const char* text) {
        if (count > 0) gltf.mesh.remarks.push_back(std::to_string(count) + text);
    };
    remark(gltf.skins, " meshes have a skin, which is left out; they are read in the pose of their node");
    remark(gltf.colored, " parts have colours of vertices, which are not used");
    for (const std::string& text : remarks_on_unused(gltf.mesh.materials)) gltf.mesh.remarks.push_back(text);
    remark(gltf.morphed, " parts have morph targets, which are left out");
    remark(gltf.incomplete, " parts have a number of vertices that is not a multiple of 3; the last ones are left out");
    if (scenes > 1 && !has_default)
        remark(scenes, " scenes are in the file, which states no default scene; the first one is read");
}

}  // namespace

FileMesh read_gltf(const MeshSource& source) {
    try {
        const GltfDocument document = parse_gltf(source);
        GltfReader gltf{document, GltfBuffers(document)};
        const json* stated = find_member(document, document.json, "scene", "the file");
        const std::uint64_t index = stated ? index_of(document, *stated, "scenes", "scene") : 0;
        const std::string name = "scenes[" + std::to_string(index) + "]";
        const json& scene = entry_of(document, "scenes", index);
        for (const json& node : array_member(document, scene, "nodes", name))
            append_node(gltf, node, Transform(), name + ".nodes");
        append_remarks(gltf, array_member(document, document.json, "scenes", "the file").size(), stated != nullptr);
        return std::move(gltf.mesh);
    } catch (const json::exception& error) {
        const std::string reason = error.what();  // the reason follows the exception's name, which is in brackets
        refuse_gltf(source, reason.substr(reason.find("] ") + 2));
    }
}

}  // namespace kagero
