#include "geometry/mesh.h"

#include "geometry/files/gltf/gltf.h"
#include "geometry/files/obj/obj.h"
#include "geometry/files/ply/header.h"
#include "geometry/files/ply/ply.h"
#include "scene/value.h"
#include "scene/vector3.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <numbers>

namespace kagero {

namespace {

[[noreturn]] void refuse(const ObjectDescription& object, const std::string& message) {
    throw InputError(object.file_location, "object." + object.name + ".file = \"" + object.file + "\": " + message);
}

/// Returns the extension of a file name in lower case: ".obj".
std::string extension_of(const std::string& path) {
    std::string extension = std::filesystem::path(path).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    return extension;
}

/// Rounds coordinates to single precision, in which most programs write and read mesh files. A coordinate that is too
/// large for it is not rounded.
void round_to_single_precision(std::vector<double>& coordinates) {
    for (double& coordinate : coordinates)
        if (std::abs(coordinate) <= double(std::numeric_limits<float>::max())) coordinate = double(float(coordinate));
}

/// Removes triangles without area and returns their number. `materials` has an entry for each triangle, or none.
std::size_t remove_degenerate(const std::vector<double>& vertices, std::vector<std::uint32_t>& triangles,
                              std::vector<std::uint32_t>& materials) {
    const auto point = [&](std::uint32_t index) {
        const double* v = &vertices[3 * std::size_t{index}];
        return Double3{v[0], v[1], v[2]};
    };
    std::vector<std::uint32_t> kept, kept_materials;
    for (std::size_t i = 0; i < triangles.size(); i += 3) {
        const std::uint32_t* corner = &triangles[i];
        const Double3 a = subtract(point(corner[1]), point(corner[0]));
        const Double3 b = subtract(point(corner[2]), point(corner[0]));
        // Twice the area, in units of the squared longest edge. Values below the rounding error of the cross product
        // count as zero.
        const double longest = std::max({length(a), length(b), length(subtract(b, a))});
        const double doubled_area = longest > 0 ? length(cross(scaled(a, 1 / longest), scaled(b, 1 / longest))) : 0;
        if (!(doubled_area > 4 * std::numeric_limits<double>::epsilon())) continue;
        kept.insert(kept.end(), corner, corner + 3);
        if (!materials.empty()) kept_materials.push_back(materials[i / 3]);
    }
    const std::size_t removed = (triangles.size() - kept.size()) / 3;
    triangles = std::move(kept);
    materials = std::move(kept_materials);
    return removed;
}

std::string remark_on_degenerate(std::size_t count) {
    return std::to_string(count) + " triangles without area were left out";
}

FileMesh read_any_format(const ObjectDescription& object) {
    // The message of an InputError is its location and the text, which is the name of the key here.
    MeshSource source{object.file,
                      {},
                      InputError(object.file_location, "object." + object.name + ".file").what(),
                      object.has_file_materials};
    std::ifstream file(object.file, std::ios::binary);
    if (!file) refuse(object, "the file cannot be read: it cannot be opened");
    source.bytes.assign(std::istreambuf_iterator<char>(file), {});
    if (source.bytes.empty()) refuse(object, "the file cannot be read: it is empty");
    const std::string extension = extension_of(object.file);
    if (extension == ".gltf" || extension == ".glb") return read_gltf(source);
    if (extension == ".obj") return read_obj(source);
    if (!is_ply(source)) refuse(object, "the file cannot be read: a PLY file must begin with the word ply");
    return read_ply(source);
}

/// Scales normals to unit length. Normals that are zero remain zero.
std::vector<double> unit_normals(std::vector<double> normals) {
    for (std::size_t i = 0; i < normals.size(); i += 3) {
        const double norm = std::hypot(normals[i], normals[i + 1], normals[i + 2]);
        const double inverse = norm > 0 && std::isfinite(norm) ? 1 / norm : 0;
        for (std::size_t k = i; k < i + 3; ++k) normals[k] = std::isfinite(inverse) ? inverse * normals[k] : 0;
    }
    return normals;
}

using Matrix = std::array<Double3, 3>;

Double3 multiply(const Matrix& m, const Double3& v) { return {dot(m[0], v), dot(m[1], v), dot(m[2], v)}; }

/// Returns the matrix of a rotation about x, then y, then z. Multiples of 90° are exact.
Matrix rotation(const Double3& degrees) {
    double c[3], s[3];
    for (std::size_t i = 0; i < 3; ++i) {
        const double quarters = degrees[i] / 90;
        const double angle = degrees[i] * (std::numbers::pi / 180);
        const bool is_multiple_of_90 = quarters == std::floor(quarters);
        c[i] = is_multiple_of_90 ? std::round(std::cos(angle)) : std::cos(angle);
        s[i] = is_multiple_of_90 ? std::round(std::sin(angle)) : std::sin(angle);
    }
    return {Double3{c[2] * c[1], c[2] * s[1] * s[0] - s[2] * c[0], c[2] * s[1] * c[0] + s[2] * s[0]},
            Double3{s[2] * c[1], s[2] * s[1] * s[0] + c[2] * c[0], s[2] * s[1] * c[0] - c[2] * s[0]},
            Double3{-s[1], c[1] * s[0], c[1] * c[0]}};
}

/// Transforms a mesh from the coordinates of its file to coordinates relative to `space.center`.
void transform_to_space(const ObjectDescription& object, const Double3& space_center, TriangleMesh& mesh) {
    const Matrix matrix = rotation(object.rotate);
    const Double3 shift = subtract(object.translate, space_center);
    for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) {
        const Double3 point{mesh.vertices[i], mesh.vertices[i + 1], mesh.vertices[i + 2]};
        const Double3 transformed = add(multiply(matrix, scaled(point, object.scale)), shift);
        for (std::size_t k = 0; k < 3; ++k) {
            if (!(std::abs(transformed[k]) <= 1e15))
                refuse(object, "vertex " + std::to_string(i / 3) +
                                   " is too far away: the limit of each coordinate, relative to "
                                   "space.center, is 1e15");
            mesh.vertices[i + k] = transformed[k];
        }
    }
    for (std::size_t i = 0; i < mesh.normals.size(); i += 3) {
        const Double3 normal = multiply(matrix, {mesh.normals[i], mesh.normals[i + 1], mesh.normals[i + 2]});
        std::copy(normal.begin(), normal.end(), mesh.normals.begin() + static_cast<std::ptrdiff_t>(i));
    }
}

/// Returns a bound on the displacement of vertices by rounding to single precision, relative to the size of the mesh.
double relative_rounding(const TriangleMesh& mesh) {
    double size = 0, farthest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        double least = std::numeric_limits<double>::infinity(), greatest = -least;
        for (std::size_t i = k; i < mesh.vertices.size(); i += 3) {
            least = std::min(least, mesh.vertices[i]);
            greatest = std::max(greatest, mesh.vertices[i]);
        }
        size = std::max(size, greatest - least);
        farthest = std::max({farthest, std::abs(least), std::abs(greatest)});
    }
    return 0.5 * double(std::numeric_limits<float>::epsilon()) * farthest / size;
}

}  // namespace

FileMesh read_mesh_file(const ObjectDescription& object) {
    FileMesh mesh = read_any_format(object);
    round_to_single_precision(mesh.vertices);
    if (!object.has_file_materials) return mesh;
    const std::size_t degenerate = remove_degenerate(mesh.vertices, mesh.triangles, mesh.material_of_triangle);
    if (degenerate > 0) mesh.remarks.push_back(remark_on_degenerate(degenerate));
    return mesh;
}

TriangleMesh load_mesh(const ObjectDescription& object, const Double3& space_center,
                       std::vector<std::string>& remarks) {
    FileMesh file = object.part ? part_of(*object.part->file, object.part->material) : read_mesh_file(object);
    TriangleMesh mesh{std::move(file.vertices), std::move(file.triangles), {}, {}};
    if (file.has_normals) mesh.normals = unit_normals(std::move(file.normals));
    if (file.has_uv) mesh.uv = std::move(file.uv);
    constexpr double visible_displacement = 1e-3;  // relative to the size of the mesh
    const double displacement = relative_rounding(mesh);
    transform_to_space(object, space_center, mesh);
    const std::size_t degenerate = remove_degenerate(mesh.vertices, mesh.triangles, file.material_of_triangle);
    if (mesh.triangles.empty())
        refuse(object, object.part ? "no triangle with " + object.part->file->materials[object.part->material].name +
                                         " has a nonzero area"
                                   : "the file has no triangle with a nonzero area");
    const std::string prefix = "object " + object.name + ": ";
    for (const std::string& remark : file.remarks) remarks.push_back(prefix + remark);
    if (degenerate > 0) remarks.push_back(prefix + remark_on_degenerate(degenerate));
    if (file.points_and_lines > 0)
        remarks.push_back(prefix + std::to_string(file.points_and_lines) + " points or lines were left out");
    const bool has_texture =
        object.paint.kind != Paint::Kind::color || (object.emission && object.emission->kind != Paint::Kind::color);
    if (mesh.uv.empty() && has_texture) {
        remarks.push_back(prefix +
                          "the file has no texture coordinates, so the whole mesh gets the colour of the texture or "
                          "checker at u = v = 0");
    } else if (file.vertices_without_uv > 0 && has_texture) {
        remarks.push_back(prefix + std::to_string(file.vertices_without_uv) +
                          " vertices without texture coordinates get the colour of the texture or checker at "
                          "u = v = 0");
    }
    if (displacement > visible_displacement)
        remarks.push_back(prefix + "the file is read in single precision, which displaces vertices by up to " +
                          to_toml(displacement) +
                          " of the mesh's size, because the mesh is far from the origin of the file. Move it to the "
                          "origin in the file, and use the key translate");
    return mesh;
}

}  // namespace kagero
