// This is the only file that includes assimp. assimp accepts vertices that are not finite and indices that are out of
// range, so this file checks all data.
#include "geometry/mesh.h"

#include "geometry/gltf_check.h"
#include "geometry/ply_check.h"
#include "scene/value.h"
#include "scene/vector3.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/DefaultLogger.hpp>
#include <assimp/Importer.hpp>
#include <assimp/LogStream.hpp>
#include <limits>
#include <mutex>
#include <numbers>

namespace kagero {

namespace {

/// Mesh in the coordinates of its file, with counts of data that is missing or left out. A part of a file is an aiMesh.
struct ImportedMesh {
    TriangleMesh mesh;
    bool has_normals = false, has_uv = false;  ///< True if any part of the file has normals or texture coordinates.
    std::size_t points_and_lines = 0;          ///< Number of points and lines, which are left out.
    std::size_t vertices_without_uv = 0;       ///< Number of vertices without texture coordinates.
    std::vector<std::string> warnings;         ///< Messages of the importer about data that it leaves out.
};

[[noreturn]] void refuse(const ObjectDescription& object, const std::string& message) {
    throw InputError(object.file_location, "object." + object.name + ".file = \"" + object.file + "\": " + message);
}

bool is_finite(double x, double y, double z) {
    return std::isfinite(x) && std::isfinite(y) && std::isfinite(z);
}

/// Returns a normal transformed by the cofactor matrix of m. This matrix equals the transposed inverse up to a factor,
/// which is made positive here. It needs no division, so it stays finite for matrices of any scale.
Double3 transformed_normal(const aiMatrix4x4& m, const aiVector3D& normal) {
    const Double3 x{m.a1, m.b1, m.c1}, y{m.a2, m.b2, m.c2}, z{m.a3, m.b3, m.c3};
    const Double3 yz = cross(y, z);
    const Double3 transformed =
        add(add(scaled(yz, normal.x), scaled(cross(z, x), normal.y)), scaled(cross(x, y), normal.z));
    return scaled(transformed, dot(x, yz) < 0 ? -1 : 1);
}

/// Appends the vertices of a part. `to_file` transforms coordinates of the part to coordinates of the file.
void append_vertices(const ObjectDescription& object, const aiMesh& part, const aiMatrix4x4& to_file,
                     ImportedMesh& out) {
    for (unsigned i = 0; i < part.mNumVertices; ++i) {
        const aiVector3D& raw = part.mVertices[i];
        const aiVector3D point = to_file * raw;
        if (!is_finite(raw.x, raw.y, raw.z) || !is_finite(point.x, point.y, point.z)) {
            refuse(object, "vertex " + std::to_string(i) + " of part \"" + std::string(part.mName.C_Str()) +
                               "\" is not finite; all coordinates must be finite numbers");
        }
        out.mesh.vertices.insert(out.mesh.vertices.end(), {point.x, point.y, point.z});
        // An invalid normal is stored as zero; shading then uses the normal of the triangle.
        const Double3 normal = part.HasNormals() ? transformed_normal(to_file, part.mNormals[i]) : Double3{};
        const double norm = std::hypot(normal[0], normal[1], normal[2]);
        const double inverse = norm > 0 && std::isfinite(norm) ? 1 / norm : 0;
        for (const double n : normal) out.mesh.normals.push_back(inverse > 0 ? inverse * n : 0);
        const aiVector3D uv = part.HasTextureCoords(0) ? part.mTextureCoords[0][i] : aiVector3D();
        if (!is_finite(uv.x, uv.y, 0))
            refuse(object, "the texture coordinates of vertex " + std::to_string(i) +
                               " are not finite; they must be finite numbers");
        out.mesh.uv.insert(out.mesh.uv.end(), {uv.x, uv.y});
    }
    out.has_normals = out.has_normals || part.HasNormals();
    out.has_uv = out.has_uv || part.HasTextureCoords(0);
    if (!part.HasTextureCoords(0)) out.vertices_without_uv += part.mNumVertices;
}

void append_part(const ObjectDescription& object, const aiMesh& part, const aiMatrix4x4& to_file, ImportedMesh& out) {
    const std::size_t first_vertex = out.mesh.vertices.size() / 3;
    if (first_vertex + part.mNumVertices > std::size_t{1} << 31)
        refuse(object, "the file has more vertices than the limit of 2^31");
    append_vertices(object, part, to_file, out);
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
        const aiFace& face = part.mFaces[f];
        if (face.mNumIndices != 3) {
            ++out.points_and_lines;
            continue;
        }
        for (unsigned k = 0; k < 3; ++k) {
            out.mesh.triangles.push_back(static_cast<std::uint32_t>(first_vertex + face.mIndices[k]));
        }
    }
}

/// Appends the parts of a node and of all its descendants, in the coordinates of the file. `parent` transforms
/// coordinates of the parent node to coordinates of the file. The recursion is as deep as the tree of nodes.
void append_node(const ObjectDescription& object, const aiScene& file, const aiNode& node, const aiMatrix4x4& parent,
                 ImportedMesh& out) {
    const aiMatrix4x4 to_file = parent * node.mTransformation;
    for (unsigned i = 0; i < node.mNumMeshes; ++i) append_part(object, *file.mMeshes[node.mMeshes[i]], to_file, out);
    for (unsigned i = 0; i < node.mNumChildren; ++i) append_node(object, file, *node.mChildren[i], to_file, out);
}

/// Maximum number of corners of a face. The triangulation of a face with so many corners takes seconds; its time grows
/// with the square of the number.
constexpr unsigned max_corners = 30000;

/// Checks the sizes and vertex indices of all faces. This precedes triangulation, which uses the indices unchecked.
void check_indices(const ObjectDescription& object, const aiScene& file) {
    for (unsigned m = 0; m < file.mNumMeshes; ++m) {
        const aiMesh& part = *file.mMeshes[m];
        for (unsigned f = 0; f < part.mNumFaces; ++f) {
            const aiFace& face = part.mFaces[f];
            if (face.mNumIndices == 0)
                refuse(object, "face " + std::to_string(f) + " has no vertices; at least one is required");
            if (face.mNumIndices > max_corners)
                refuse(object, "face " + std::to_string(f) + " has " + std::to_string(face.mNumIndices) +
                                   " vertices; the limit is " + std::to_string(max_corners) +
                                   ". Divide the face into smaller ones");
            for (unsigned k = 0; k < face.mNumIndices; ++k) {
                if (face.mIndices[k] < part.mNumVertices) continue;
                refuse(object, "face " + std::to_string(f) + " has the vertex index " +
                                   std::to_string(face.mIndices[k]) + ", but its part has only " +
                                   std::to_string(part.mNumVertices) + " vertices");
            }
        }
    }
}

/// Collects the importer's messages about data that it leaves out. The importer's log is global, so each object of this
/// class holds a lock during its lifetime.
class ImporterLog : public Assimp::LogStream {
public:
    explicit ImporterLog(std::vector<std::string>& warnings) : lock_(mutex_), warnings_(warnings) {
        Assimp::DefaultLogger::create("", Assimp::Logger::NORMAL, 0)->attachStream(this, levels);
    }
    ~ImporterLog() override {
        Assimp::DefaultLogger::get()->detachStream(this, levels);
        Assimp::DefaultLogger::kill();
    }
    void write(const char* text) override {
        std::string line = text;
        for (const char* word : {"dropped", "out-of-range", "Skipping", "skipping", "Ignoring"}) {
            if (line.find(word) == std::string::npos) continue;
            line.erase(line.find_last_not_of(" \r\n") + 1);
            const std::size_t colon = line.find(": ");  // the message follows the level and the thread
            warnings_.push_back(colon == std::string::npos ? line : line.substr(colon + 2));
            return;
        }
    }

private:
    static constexpr unsigned levels = Assimp::Logger::Warn | Assimp::Logger::Err;
    static inline std::mutex mutex_;
    std::lock_guard<std::mutex> lock_;
    std::vector<std::string>& warnings_;
};

ImportedMesh read_file(const ObjectDescription& object) {
    if (is_ply(object.file)) check_ply(object.file);
    if (is_gltf(object.file)) check_gltf(object.file);
    ImportedMesh imported;
    const ImporterLog importer_log(imported.warnings);
    try {
        Assimp::Importer importer;
        const aiScene* file = importer.ReadFile(object.file, 0);
        const std::string reason = importer.GetErrorString();
        if (!file || !file->mRootNode)
            refuse(object, "the file cannot be read: " + (reason.empty() ? "it contains no scene" : reason));
        check_indices(object, *file);
        file = importer.ApplyPostProcessing(aiProcess_Triangulate);
        if (!file || !file->mRootNode)
            refuse(object, std::string("the faces cannot be triangulated: ") + importer.GetErrorString());
        append_node(object, *file, *file->mRootNode, aiMatrix4x4(), imported);
        for (const std::string& warning : imported.warnings) {
            if (warning.find("out-of-range") != std::string::npos) refuse(object, warning);
        }
    } catch (const InputError&) {
        throw;
    } catch (const std::exception& error) {
        refuse(object, std::string("the file cannot be read: ") + error.what());
    }
    return imported;
}

using Matrix = std::array<Double3, 3>;

Double3 multiply(const Matrix& m, const Double3& v) {
    return {dot(m[0], v), dot(m[1], v), dot(m[2], v)};
}

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

/// Removes triangles without area and returns their number.
std::size_t remove_degenerate(TriangleMesh& mesh) {
    std::vector<std::uint32_t> kept;
    for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
        const std::uint32_t* corner = &mesh.triangles[i];
        const Double3 a = subtract(vertex(mesh, corner[1]), vertex(mesh, corner[0]));
        const Double3 b = subtract(vertex(mesh, corner[2]), vertex(mesh, corner[0]));
        // Twice the area, in units of the squared longest edge. Values below the rounding error of the cross product
        // count as zero.
        const double longest = std::max({length(a), length(b), length(subtract(b, a))});
        const double doubled_area = longest > 0 ? length(cross(scaled(a, 1 / longest), scaled(b, 1 / longest))) : 0;
        if (doubled_area > 4 * std::numeric_limits<double>::epsilon()) kept.insert(kept.end(), corner, corner + 3);
    }
    const std::size_t removed = (mesh.triangles.size() - kept.size()) / 3;
    mesh.triangles = std::move(kept);
    return removed;
}

/// Returns a bound on the displacement of vertices by rounding to single precision, in which the importer reads files.
/// The bound is relative to the size of the mesh.
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

TriangleMesh load_mesh(const ObjectDescription& object, const Double3& space_center,
                       std::vector<std::string>& remarks) {
    ImportedMesh imported = read_file(object);
    TriangleMesh& mesh = imported.mesh;
    if (!imported.has_normals) mesh.normals.clear();
    if (!imported.has_uv) mesh.uv.clear();
    constexpr double visible_displacement = 1e-3;  // relative to the size of the mesh
    const double displacement = relative_rounding(mesh);
    transform_to_space(object, space_center, mesh);
    const std::size_t degenerate = remove_degenerate(mesh);
    if (mesh.triangles.empty()) refuse(object, "the file has no triangle with a nonzero area");
    const std::string prefix = "object " + object.name + ": ";
    for (const std::string& warning : imported.warnings) remarks.push_back(prefix + warning);
    if (degenerate > 0)
        remarks.push_back(prefix + std::to_string(degenerate) + " triangles without area were left out");
    if (imported.points_and_lines > 0)
        remarks.push_back(prefix + std::to_string(imported.points_and_lines) + " points or lines were left out");
    if (mesh.uv.empty() && object.paint.kind != Paint::Kind::color) {
        remarks.push_back(prefix +
                          "the file has no texture coordinates, so the whole mesh gets the colour of the texture or "
                          "checker at u = v = 0");
    } else if (imported.vertices_without_uv > 0 && object.paint.kind != Paint::Kind::color) {
        remarks.push_back(prefix + std::to_string(imported.vertices_without_uv) +
                          " vertices without texture coordinates get the colour of the texture or checker at "
                          "u = v = 0");
    }
    if (displacement > visible_displacement)
        remarks.push_back(prefix + "the file is read in single precision, which displaces vertices by up to " +
                          to_toml(displacement) +
                          " of the mesh's size, because the mesh is far from the origin of the file. Move it to the "
                          "origin in the file, and use the key translate");
    return std::move(mesh);
}

}  // namespace kagero
