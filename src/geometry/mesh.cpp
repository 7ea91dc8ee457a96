// The only file that includes assimp. It accepts vertices that are not numbers and indices out of range, so everything
// is checked here.
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

struct Collected {
    TriangleMesh mesh;
    bool has_normals = false, has_uv = false;  ///< of any part
    std::size_t others = 0;                    ///< points and lines
    std::size_t without_uv = 0;                ///< vertices
    std::vector<std::string> warnings;
};

[[noreturn]] void refuse(const ObjectDescription& object, const std::string& message) {
    throw InputError(object.file_place, "object." + object.name + ".file = \"" + object.file + "\": " + message);
}

bool finite(double x, double y, double z) {
    return std::isfinite(x) && std::isfinite(y) && std::isfinite(z);
}

/// How a matrix turns normals: its cofactors, the inverse's transpose but for a positive factor, which has no range to
/// leave.
Double3 turned_normal(const aiMatrix4x4& m, const aiVector3D& normal) {
    const Double3 x{m.a1, m.b1, m.c1}, y{m.a2, m.b2, m.c2}, z{m.a3, m.b3, m.c3};
    const Double3 yz = cross(y, z);
    const Double3 turned = add(add(scaled(yz, normal.x), scaled(cross(z, x), normal.y)), scaled(cross(x, y), normal.z));
    return scaled(turned, dot(x, yz) < 0 ? -1 : 1);
}

void append_vertices(const ObjectDescription& object, const aiMesh& part, const aiMatrix4x4& to_file, Collected& out) {
    for (unsigned i = 0; i < part.mNumVertices; ++i) {
        const aiVector3D& raw = part.mVertices[i];
        const aiVector3D point = to_file * raw;
        if (!finite(raw.x, raw.y, raw.z) || !finite(point.x, point.y, point.z)) {
            refuse(object,
                   "vertex " + std::to_string(i) + " of part " + std::string(part.mName.C_Str()) + " is not finite");
        }
        out.mesh.vertices.insert(out.mesh.vertices.end(), {point.x, point.y, point.z});
        // A normal that is none becomes zero: shading then takes the triangle's own.
        const Double3 normal = part.HasNormals() ? turned_normal(to_file, part.mNormals[i]) : Double3{};
        const double norm = std::hypot(normal[0], normal[1], normal[2]);
        const double inverse = norm > 0 && std::isfinite(norm) ? 1 / norm : 0;
        for (const double n : normal) out.mesh.normals.push_back(inverse > 0 ? inverse * n : 0);
        const aiVector3D uv = part.HasTextureCoords(0) ? part.mTextureCoords[0][i] : aiVector3D();
        if (!finite(uv.x, uv.y, 0))
            refuse(object, "the texture coordinates of vertex " + std::to_string(i) + " are not finite");
        out.mesh.uv.insert(out.mesh.uv.end(), {uv.x, uv.y});
    }
    out.has_normals = out.has_normals || part.HasNormals();
    out.has_uv = out.has_uv || part.HasTextureCoords(0);
    if (!part.HasTextureCoords(0)) out.without_uv += part.mNumVertices;
}

void append_part(const ObjectDescription& object, const aiMesh& part, const aiMatrix4x4& to_file, Collected& out) {
    const std::size_t first = out.mesh.vertices.size() / 3;
    if (first + part.mNumVertices > std::size_t{1} << 31) refuse(object, "more than 2^31 vertices");
    append_vertices(object, part, to_file, out);
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
        const aiFace& face = part.mFaces[f];
        if (face.mNumIndices != 3) {
            ++out.others;
            continue;
        }
        for (unsigned k = 0; k < 3; ++k) {
            out.mesh.triangles.push_back(static_cast<std::uint32_t>(first + face.mIndices[k]));
        }
    }
}

/// The nodes of a file place its parts; recursion is as deep as the file's tree.
void append_node(const ObjectDescription& object, const aiScene& file, const aiNode& node, const aiMatrix4x4& parent,
                 Collected& out) {
    const aiMatrix4x4 to_file = parent * node.mTransformation;
    for (unsigned i = 0; i < node.mNumMeshes; ++i) append_part(object, *file.mMeshes[node.mMeshes[i]], to_file, out);
    for (unsigned i = 0; i < node.mNumChildren; ++i) append_node(object, file, *node.mChildren[i], to_file, out);
}

/// A face of as many is cut into triangles in seconds; the time grows by their square.
constexpr unsigned most_corners = 30000;

/// Indices are judged before triangulation, which follows them.
void check_indices(const ObjectDescription& object, const aiScene& file) {
    for (unsigned m = 0; m < file.mNumMeshes; ++m) {
        const aiMesh& part = *file.mMeshes[m];
        for (unsigned f = 0; f < part.mNumFaces; ++f) {
            const aiFace& face = part.mFaces[f];
            if (face.mNumIndices == 0) refuse(object, "face " + std::to_string(f) + " has no vertices");
            if (face.mNumIndices > most_corners)
                refuse(object, "face " + std::to_string(f) + " has " + std::to_string(face.mNumIndices) +
                                   " vertices: legal are at most " + std::to_string(most_corners));
            for (unsigned k = 0; k < face.mNumIndices; ++k) {
                if (face.mIndices[k] < part.mNumVertices) continue;
                refuse(object, "face " + std::to_string(f) + " names vertex " + std::to_string(face.mIndices[k]) +
                                   ", but there are only " + std::to_string(part.mNumVertices));
            }
        }
    }
}

/// Collects what the importer says about data that it leaves out on its own. Its log belongs to the whole program,
/// hence the lock.
class Listener : public Assimp::LogStream {
public:
    explicit Listener(std::vector<std::string>& warnings) : lock_(mutex_), warnings_(warnings) {
        Assimp::DefaultLogger::create("", Assimp::Logger::NORMAL, 0)->attachStream(this, levels);
    }
    ~Listener() override {
        Assimp::DefaultLogger::get()->detachStream(this, levels);
        Assimp::DefaultLogger::kill();
    }
    void write(const char* text) override {
        std::string line = text;
        for (const char* word : {"dropped", "out-of-range", "Skipping", "skipping", "Ignoring"}) {
            if (line.find(word) == std::string::npos) continue;
            line.erase(line.find_last_not_of(" \r\n") + 1);
            const std::size_t colon = line.find(": ");  // after level and thread
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

Collected read_file(const ObjectDescription& object) {
    if (is_ply(object.file)) check_ply(object.file);
    if (is_gltf(object.file)) check_gltf(object.file);
    Collected collected;
    const Listener listener(collected.warnings);
    try {
        Assimp::Importer importer;
        const aiScene* file = importer.ReadFile(object.file, 0);
        const std::string reason = importer.GetErrorString();
        if (!file || !file->mRootNode)
            refuse(object, "cannot be read: " + (reason.empty() ? "it holds no scene" : reason));
        check_indices(object, *file);
        file = importer.ApplyPostProcessing(aiProcess_Triangulate);
        if (!file || !file->mRootNode)
            refuse(object, std::string("cannot be triangulated: ") + importer.GetErrorString());
        append_node(object, *file, *file->mRootNode, aiMatrix4x4(), collected);
        for (const std::string& warning : collected.warnings) {
            if (warning.find("out-of-range") != std::string::npos) refuse(object, warning);
        }
    } catch (const InputError&) {
        throw;
    } catch (const std::exception& error) {
        refuse(object, std::string("cannot be read: ") + error.what());
    }
    return collected;
}

using Matrix = std::array<Double3, 3>;

Double3 multiply(const Matrix& m, const Double3& v) {
    return {dot(m[0], v), dot(m[1], v), dot(m[2], v)};
}

/// Rotation about x, then y, then z; a quarter turn is exact.
Matrix rotation(const Double3& degrees) {
    double c[3], s[3];
    for (std::size_t i = 0; i < 3; ++i) {
        const double quarters = degrees[i] / 90;
        const double angle = degrees[i] * (std::numbers::pi / 180);
        const bool exact = quarters == std::floor(quarters);
        c[i] = exact ? std::round(std::cos(angle)) : std::cos(angle);
        s[i] = exact ? std::round(std::sin(angle)) : std::sin(angle);
    }
    return {Double3{c[2] * c[1], c[2] * s[1] * s[0] - s[2] * c[0], c[2] * s[1] * c[0] + s[2] * s[0]},
            Double3{s[2] * c[1], s[2] * s[1] * s[0] + c[2] * c[0], s[2] * s[1] * c[0] - c[2] * s[0]},
            Double3{-s[1], c[1] * s[0], c[1] * c[0]}};
}

void place_in_space(const ObjectDescription& object, const Double3& space_center, TriangleMesh& mesh) {
    const Matrix turn = rotation(object.rotate);
    const Double3 shift = subtract(object.translate, space_center);
    for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) {
        const Double3 point{mesh.vertices[i], mesh.vertices[i + 1], mesh.vertices[i + 2]};
        const Double3 placed = add(multiply(turn, scaled(point, object.scale)), shift);
        for (std::size_t k = 0; k < 3; ++k) {
            if (!(std::abs(placed[k]) <= 1e15))
                refuse(object, "vertex " + std::to_string(i / 3) + " lies too far out, beyond 1e15");
            mesh.vertices[i + k] = placed[k];
        }
    }
    for (std::size_t i = 0; i < mesh.normals.size(); i += 3) {
        const Double3 normal = multiply(turn, {mesh.normals[i], mesh.normals[i + 1], mesh.normals[i + 2]});
        std::copy(normal.begin(), normal.end(), mesh.normals.begin() + static_cast<std::ptrdiff_t>(i));
    }
}

/// Removes triangles without area; returns how many.
std::size_t drop_degenerate(TriangleMesh& mesh) {
    std::vector<std::uint32_t> kept;
    for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
        const std::uint32_t* corner = &mesh.triangles[i];
        const Double3 a = subtract(vertex(mesh, corner[1]), vertex(mesh, corner[0]));
        const Double3 b = subtract(vertex(mesh, corner[2]), vertex(mesh, corner[0]));
        // Relative to the longest edge, area below the rounding of its own cross product is none.
        const double longest = std::max({length(a), length(b), length(subtract(b, a))});
        const double area = longest > 0 ? length(cross(scaled(a, 1 / longest), scaled(b, 1 / longest))) : 0;
        if (area > 4 * std::numeric_limits<double>::epsilon()) kept.insert(kept.end(), corner, corner + 3);
    }
    const std::size_t dropped = (mesh.triangles.size() - kept.size()) / 3;
    mesh.triangles = std::move(kept);
    return dropped;
}

/// How far rounding to single precision, in which files are read, may move a vertex; as a share of the mesh's size.
double rounded_off(const TriangleMesh& mesh) {
    double size = 0, farthest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        double least = std::numeric_limits<double>::infinity(), greatest = -least;
        for (std::size_t i = k; i < mesh.vertices.size(); i += 3)
            least = std::min(least, mesh.vertices[i]), greatest = std::max(greatest, mesh.vertices[i]);
        size = std::max(size, greatest - least), farthest = std::max({farthest, std::abs(least), std::abs(greatest)});
    }
    return 0.5 * double(std::numeric_limits<float>::epsilon()) * farthest / size;
}

}  // namespace

TriangleMesh load_mesh(const ObjectDescription& object, const Double3& space_center,
                       std::vector<std::string>& remarks) {
    Collected collected = read_file(object);
    TriangleMesh& mesh = collected.mesh;
    if (!collected.has_normals) mesh.normals.clear();
    if (!collected.has_uv) mesh.uv.clear();
    constexpr double visible = 1e-3;
    const double rounded = rounded_off(mesh);
    place_in_space(object, space_center, mesh);
    const std::size_t degenerate = drop_degenerate(mesh);
    if (mesh.triangles.empty()) refuse(object, "has no triangle with an area");
    const std::string start = "object " + object.name + ": ";
    for (const std::string& warning : collected.warnings) remarks.push_back(start + warning);
    if (degenerate > 0) remarks.push_back(start + std::to_string(degenerate) + " triangles without area left out");
    if (collected.others > 0) remarks.push_back(start + std::to_string(collected.others) + " points or lines left out");
    if (mesh.uv.empty() && object.paint.kind != Paint::Kind::color) {
        remarks.push_back(start +
                          "no texture coordinates in the file: the whole mesh takes the paint's colour at (0, 0)");
    } else if (collected.without_uv > 0 && object.paint.kind != Paint::Kind::color) {
        remarks.push_back(start + std::to_string(collected.without_uv) +
                          " vertices without texture coordinates take the paint's colour at (0, 0)");
    }
    if (rounded > visible)
        remarks.push_back(start +
                          "its coordinates lie so far from the origin of the file, which is read in single precision, "
                          "that vertices move by up to " +
                          written(rounded) + " of its size");
    return std::move(mesh);
}

}  // namespace kagero
