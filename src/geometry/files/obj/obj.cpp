#include "geometry/files/obj/obj.h"

#include "geometry/files/obj/mtl.h"
#include "geometry/files/obj/statements.h"
#include "geometry/files/polygons.h"

#include <algorithm>
#include <charconv>
#include <numeric>

namespace kagero {

namespace {

/// A kind of data to which the corners of faces refer by indices.
struct ObjData {
    const char* name;       ///< Name of an index in messages.
    std::size_t dimension;  ///< Numbers per entry.
    std::vector<double> numbers{};

    std::size_t size() const { return numbers.size() / dimension; }
    const double* entry(std::int64_t index) const {
        return index < 0 ? nullptr : &numbers[dimension * static_cast<std::size_t>(index)];
    }
};

constexpr std::int64_t no_index = -1;

/// A corner of a face: indices of a position, of texture coordinates and of a normal, counted from 0.
using ObjCorner = std::array<std::int64_t, 3>;

/// The contents of an OBJ file as they are stated.
struct ObjContents {
    const MeshSource& source;
    std::array<ObjData, 3> data{ObjData{"vertex", 3}, ObjData{"texture coordinate", 2}, ObjData{"normal", 3}};
    std::string part = "defaultobject";  ///< Name of the current object or group.
    std::vector<ObjCorner> corners{};    ///< Corners of all faces.
    std::vector<std::uint32_t> sizes{};  ///< Number of corners of each face.
    std::vector<std::size_t> lines{};    ///< Line of each face.
    std::vector<std::uint32_t> uses{};   ///< Index in `material_uses` of each face.
    std::vector<std::pair<std::string, std::size_t>> material_uses{{"", 0}};  ///< Names of materials, with their lines.
    std::size_t points_and_lines = 0;
    std::size_t empty_faces = 0;
    std::size_t weighted_vertices = 0;  ///< Number of vertices with a weight other than 1.
};

[[noreturn]] void refuse_statement(const ObjContents& obj, std::size_t line, const std::string& reason) {
    refuse_file(obj.source, line, "OBJ: " + reason);
}

/// Returns the numbers of a statement. `expected` describes the legal numbers.
std::vector<double> numbers_of(const ObjContents& obj, const ObjStatement& statement, std::size_t least,
                               std::size_t greatest, const char* expected) {
    const std::size_t count = statement.words.size() - 1;
    if (count < least || count > greatest)
        refuse_statement(obj, statement.line,
                         in_quotes(statement.words[0]) + " has " + std::to_string(count) + " numbers; it needs " +
                             expected);
    std::vector<double> numbers(count);
    for (std::size_t i = 0; i < count; ++i)
        if (!parse_number(statement.words[i + 1], numbers[i]))
            refuse_statement(obj, statement.line,
                             in_quotes(statement.words[i + 1]) + " is not a number; " + in_quotes(statement.words[0]) +
                                 " needs " + expected);
    return numbers;
}

void read_vertex(ObjContents& obj, const ObjStatement& statement) {
    static const char* const expected = "3 numbers (x y z), 4 (x y z w) or 6 (x y z and a colour)";
    const std::vector<double> numbers = numbers_of(obj, statement, 3, 6, expected);
    if (numbers.size() == 5)
        refuse_statement(obj, statement.line, "\"v\" has 5 numbers; it needs " + std::string(expected));
    Double3 point{numbers[0], numbers[1], numbers[2]};
    ObjData& positions = obj.data[0];
    if (numbers.size() == 4 && numbers[3] != 1) {
        if (numbers[3] == 0)
            refuse_statement(obj, statement.line,
                             "the weight w of vertex " + std::to_string(positions.size()) +
                                 " is 0; it must not be 0, because x, y and z are divided by it");
        point = {point[0] / numbers[3], point[1] / numbers[3], point[2] / numbers[3]};
        ++obj.weighted_vertices;
    }
    if (!is_finite(point)) refuse_statement(obj, statement.line, reason_not_finite(positions.size(), obj.part, point));
    positions.numbers.insert(positions.numbers.end(), point.begin(), point.end());
}

void read_texture_coordinates(ObjContents& obj, const ObjStatement& statement) {
    const std::vector<double> numbers = numbers_of(obj, statement, 1, 3, "1 to 3 numbers (u v w)");
    const double u = numbers[0], v = numbers.size() > 1 ? numbers[1] : 0;
    ObjData& coordinates = obj.data[1];
    if (!std::isfinite(u) || !std::isfinite(v))
        refuse_statement(obj, statement.line,
                         "the texture coordinates " + std::to_string(coordinates.size()) +
                             " are not finite; they must be finite numbers");
    coordinates.numbers.insert(coordinates.numbers.end(), {u, v});
}

void read_normal(ObjContents& obj, const ObjStatement& statement) {
    const std::vector<double> normal = numbers_of(obj, statement, 3, 3, "3 numbers (x y z)");
    obj.data[2].numbers.insert(obj.data[2].numbers.end(), normal.begin(), normal.end());
}

[[noreturn]] void refuse_index(const ObjContents& obj, std::size_t line, const ObjData& data,
                               const std::string& index) {
    const std::string count = std::to_string(data.size());
    refuse_statement(obj, line,
                     "index out of range: the " + std::string(data.name) + " index " + index + " is not legal; " +
                         (data.size() == 0 ? "there are none"
                                           : "legal are 1 to " + count + " and -" + count + " to -1"));
}

/// Reads a corner "v", "v/vt", "v/vt/vn" or "v//vn". Indices are counted from 1, and negative ones backward from the
/// last entry so far. Positive indices may refer to later lines, so they are checked at the end of the file.
ObjCorner read_corner(const ObjContents& obj, std::size_t line, std::string_view word) {
    ObjCorner corner{no_index, no_index, no_index};
    std::string_view rest = word;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t end = std::min(rest.find('/'), rest.size());
        std::string_view text = rest.substr(0, end);
        const bool is_last = end == rest.size();
        rest.remove_prefix(is_last ? end : end + 1);
        if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
        std::int64_t index = 0;
        const auto result = std::from_chars(text.data(), text.data() + text.size(), index);
        const bool is_number = result.ec == std::errc{} && result.ptr == text.data() + text.size();
        const bool is_missing = text.empty() && k > 0;
        if ((!is_number && !is_missing) || (k == 2 && !is_last))
            refuse_statement(obj, line,
                             "the corner " + in_quotes(word) +
                                 " is not legal; it must have the form v, v/vt, "
                                 "v/vt/vn or v//vn with whole numbers");
        const ObjData& data = obj.data[k];
        if (!is_missing) {
            if (index == 0 || index < -static_cast<std::int64_t>(data.size()))
                refuse_index(obj, line, data, std::to_string(index));
            corner[k] = index > 0 ? index - 1 : static_cast<std::int64_t>(data.size()) + index;
        }
        if (is_last) break;
    }
    return corner;
}

void read_face(ObjContents& obj, const ObjStatement& statement) {
    const std::size_t count = statement.words.size() - 1;
    if (count == 0) {
        ++obj.empty_faces;
        return;
    }
    const std::string reason = reason_wrong_face_size(obj.sizes.size(), count);
    if (!reason.empty()) refuse_statement(obj, statement.line, reason);
    for (std::size_t i = 1; i <= count; ++i)
        obj.corners.push_back(read_corner(obj, statement.line, statement.words[i]));
    obj.sizes.push_back(static_cast<std::uint32_t>(count));
    obj.lines.push_back(statement.line);
    obj.uses.push_back(std::uint32_t(obj.material_uses.size() - 1));
}

void read_name(ObjContents& obj, const ObjStatement& statement) {
    const std::string_view word = statement.words[0];
    if ((word == "o" || word == "g") && statement.words.size() > 1) obj.part = statement.words[1];
    if (word == "usemtl") obj.material_uses.emplace_back(name_in(statement), statement.line);
}

/// Counts the points or the segments of a line. Their indices are checked like those of faces, except that they must
/// not refer to later lines.
void read_points_or_line(ObjContents& obj, const ObjStatement& statement) {
    for (std::size_t i = 1; i < statement.words.size(); ++i) read_corner(obj, statement.line, statement.words[i]);
    const std::size_t ends = statement.kind == ObjKind::line ? 1 : 0;
    obj.points_and_lines += std::max(statement.words.size() - 1, ends) - ends;
}

void read_statement(ObjContents& obj, const ObjStatement& statement) {
    const std::string word(statement.words[0]);
    switch (statement.kind) {
        case ObjKind::vertex: return read_vertex(obj, statement);
        case ObjKind::texture_coordinates: return read_texture_coordinates(obj, statement);
        case ObjKind::normal: return read_normal(obj, statement);
        case ObjKind::face: return read_face(obj, statement);
        case ObjKind::line:
        case ObjKind::point: return read_points_or_line(obj, statement);
        case ObjKind::ignored: return;
        case ObjKind::name: return read_name(obj, statement);
        case ObjKind::surface:
            refuse_statement(obj, statement.line,
                             "the statement " + in_quotes(word) +
                                 " is not supported; only polygons "
                                 "(\"f\") are read. Convert the geometry to polygons");
        case ObjKind::unknown: break;
    }
    const std::string near = near_match(word, obj_keywords());
    refuse_statement(obj, statement.line,
                     in_quotes(word) + " is not a statement of OBJ files" +
                         (near.empty() ? "" : "; did you mean \"" + near + "\"?"));
}

void check_indices(const ObjContents& obj) {
    std::size_t first = 0;
    for (std::size_t face = 0; face < obj.sizes.size(); ++face) {
        for (std::size_t i = first; i < first + obj.sizes[face]; ++i)
            for (std::size_t k = 0; k < 3; ++k)
                if (obj.corners[i][k] >= static_cast<std::int64_t>(obj.data[k].size()))
                    refuse_index(obj, obj.lines[face], obj.data[k], std::to_string(obj.corners[i][k] + 1));
        first += obj.sizes[face];
    }
}

/// Creates the vertices, one for each distinct corner, and returns the index of the vertex of every corner. The
/// vertices are sorted by their position in the file.
std::vector<std::uint32_t> append_corners(const ObjContents& obj, FileMesh& mesh) {
    std::vector<std::uint32_t> order(obj.corners.size()), vertices(obj.corners.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return obj.corners[a] < obj.corners[b]; });
    std::uint32_t count = 0;
    for (std::size_t i = 0; i < order.size(); ++i) {
        const ObjCorner& corner = obj.corners[order[i]];
        if (i == 0 || corner != obj.corners[order[i - 1]]) {
            const double* point = obj.data[0].entry(corner[0]);
            append_vertex(mesh, {point[0], point[1], point[2]}, obj.data[2].entry(corner[2]),
                          obj.data[1].entry(corner[1]));
            ++count;
        }
        vertices[order[i]] = count - 1;
    }
    return vertices;
}

/// Sets the materials of the mesh to those that faces use. Returns, for each use of a material in the file, its index.
std::vector<std::uint32_t> set_materials(const ObjContents& obj, FileMesh& mesh) {
    MtlMaterials known;
    const bool has_libraries = !read_libraries(obj.source, known).empty();
    std::map<std::string, std::uint32_t> indices;
    std::vector<std::uint32_t> index_of_use(obj.material_uses.size());
    for (const std::uint32_t use : obj.uses) {
        const auto& [name, line] = obj.material_uses[use];
        const auto [found, is_new] = indices.emplace(name, std::uint32_t(mesh.materials.size()));
        index_of_use[use] = found->second;
        if (!is_new) continue;
        FileMaterial material;
        material.name = "faces without a material";
        if (!name.empty()) {
            const auto stated = known.find(name);
            if (stated == known.end())
                refuse_statement(obj, line,
                                 "the material " + in_quotes(name) + " is not in " +
                                     (has_libraries ? "the files of mtllib"
                                                    : "a file: the file has no statement mtllib") +
                                     "; add it, or state materials = \"scene\"");
            material = stated->second;
        }
        mesh.materials.push_back(std::move(material));
    }
    for (std::string& remark : remarks_on_unused(mesh.materials)) mesh.remarks.push_back(std::move(remark));
    return index_of_use;
}

/// Gives the corners of faces vertices of their own, whose texture coordinates are those that a material states.
void separate_vertices(FileMesh& mesh, const FileMaterial& material, std::vector<std::uint32_t>& corners) {
    std::map<std::uint32_t, std::uint32_t> copies;
    for (std::uint32_t& corner : corners) {
        const auto [copy, is_new] = copies.emplace(corner, std::uint32_t(mesh.vertices.size() / 3));
        if (is_new) {
            const std::size_t i = 3 * std::size_t{corner}, k = 2 * std::size_t{corner};
            const std::array<double, 2> uv = material.uv_transform({mesh.uv[k], mesh.uv[k + 1]});
            const Double3 point{mesh.vertices[i], mesh.vertices[i + 1], mesh.vertices[i + 2]},
                normal{mesh.normals[i], mesh.normals[i + 1], mesh.normals[i + 2]};
            const bool has_normals = mesh.has_normals;
            append_vertex(mesh, point, normal.data(), uv.data());
            mesh.has_normals = has_normals;
        }
        corner = copy->second;
    }
}

/// Appends the triangles of all faces, grouped by material, and transforms their texture coordinates.
void append_faces_by_material(const ObjContents& obj, const std::vector<std::uint32_t>& corners, FileMesh& mesh) {
    const std::vector<std::uint32_t> index_of_use = set_materials(obj, mesh);
    std::vector<Polygons> groups(mesh.materials.size());
    std::size_t first = 0;
    for (std::size_t face = 0; face < obj.sizes.size(); ++face) {
        Polygons& group = groups[index_of_use[obj.uses[face]]];
        const auto begin = corners.begin() + std::ptrdiff_t(first);
        group.corners.insert(group.corners.end(), begin, begin + obj.sizes[face]);
        group.sizes.push_back(obj.sizes[face]);
        first += obj.sizes[face];
    }
    for (std::uint32_t i = 0; i < groups.size(); ++i) {
        if (mesh.materials[i].uv_transform != UvTransform())
            separate_vertices(mesh, mesh.materials[i], groups[i].corners);
        append_polygons(mesh, groups[i]);
        mesh.material_of_triangle.resize(mesh.triangles.size() / 3, i);
    }
}

}  // namespace

FileMesh read_obj(const MeshSource& source) {
    ObjContents obj{source};
    ObjStatements statements(source.bytes);
    for (ObjStatement statement; statements.next(statement);) read_statement(obj, statement);
    check_indices(obj);
    check_number_of_vertices(source, obj.corners.size());
    FileMesh mesh;
    mesh.points_and_lines = obj.points_and_lines;
    std::vector<std::uint32_t> corners = append_corners(obj, mesh);
    if (source.reads_materials) append_faces_by_material(obj, corners, mesh);
    else append_polygons(mesh, {std::move(corners), obj.sizes});
    if (obj.empty_faces > 0)
        mesh.remarks.push_back(std::to_string(obj.empty_faces) + " faces without vertices were left out");
    if (obj.weighted_vertices > 0)
        mesh.remarks.push_back(std::to_string(obj.weighted_vertices) +
                               " vertices have a weight w other than 1; their x, y and z were divided by it");
    return mesh;
}

}  // namespace kagero
