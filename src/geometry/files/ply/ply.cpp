#include "geometry/files/ply/ply.h"

#include "geometry/files/ply/rows.h"
#include "geometry/files/polygons.h"

#include <algorithm>

namespace kagero {

namespace {

/// State of a reader of a PLY file.
struct PlyReader {
    const MeshSource& source;
    PlyRows rows;
    std::uint64_t vertex_count = 0;  ///< Number of vertices that the header declares.
    FileMesh mesh{};
    Polygons polygons{};
    std::vector<std::uint32_t> strips{};    ///< Vertex indices of all parts of all strips.
    std::vector<std::size_t> strip_ends{};  ///< End of each part in `strips`.
    std::vector<double> corner_uv{};        ///< u and v of every corner in `polygons`; NaN where there are none.
    bool has_corner_uv = false;
    std::vector<std::string> skipped{};  ///< Names of elements that are left out.
};

/// Returns the position of a property that must be a number if it exists; −1 if it does not.
std::ptrdiff_t find_number(const PlyReader& ply, const PlyElement& element, const char* name) {
    const std::ptrdiff_t property = find_property(element, name);
    const auto count = std::count_if(element.properties.begin(), element.properties.end(),
                                     [&](const PlyProperty& other) { return other.name == name; });
    if (property >= 0 && (count > 1 || element.properties[static_cast<std::size_t>(property)].is_list()))
        refuse_ply(ply.source, 0,
                   "the property " + in_quotes(name) + " of the element " + in_quotes(element.name) +
                       (count > 1 ? " is declared twice" : " is a list; it must be a number"));
    return property;
}

/// Returns the position of the list of vertex indices. Both names of this list are common.
std::ptrdiff_t find_indices(const PlyReader& ply, const PlyElement& element) {
    std::string names;
    for (const PlyProperty& property : element.properties) {
        const bool is_indices = property.name == "vertex_indices" || property.name == "vertex_index";
        if (is_indices && property.is_list()) return &property - element.properties.data();
        append_to_list(names, in_quotes(property.name));
    }
    refuse_ply(ply.source, 0,
               "the element " + in_quotes(element.name) +
                   " has no list vertex_indices or vertex_index; its properties are " +
                   (names.empty() ? "missing" : names));
}

/// Positions of the properties of a vertex that are used. −1 stands for a missing property.
struct VertexProperties {
    std::array<std::ptrdiff_t, 3> point{-1, -1, -1}, normal{-1, -1, -1};
    std::array<std::ptrdiff_t, 2> uv{-1, -1};
};

VertexProperties vertex_properties(const PlyReader& ply, const PlyElement& element) {
    static constexpr const char* uv_names[][2] = {{"s", "t"},
                                                  {"u", "v"},
                                                  {"texture_u", "texture_v"},
                                                  {"texture_s", "texture_t"}};
    static constexpr const char* axes[][2] = {{"x", "nx"}, {"y", "ny"}, {"z", "nz"}};
    VertexProperties result;
    for (std::size_t k = 0; k < 3; ++k) {
        result.point[k] = find_number(ply, element, axes[k][0]);
        result.normal[k] = find_number(ply, element, axes[k][1]);
        if (result.point[k] < 0)
            refuse_ply(ply.source, 0,
                       "the element \"vertex\" has no property " + in_quotes(axes[k][0]) + "; x, y and z are required");
    }
    for (const auto& names : uv_names) {
        if (result.uv[0] >= 0 && result.uv[1] >= 0) break;
        result.uv = {find_number(ply, element, names[0]), find_number(ply, element, names[1])};
    }
    return result;
}

void read_vertices(PlyReader& ply, const PlyElement& element) {
    const VertexProperties properties = vertex_properties(ply, element);
    const auto exists = [](std::ptrdiff_t property) { return property >= 0; };
    const bool has_normal = std::all_of(properties.normal.begin(), properties.normal.end(), exists);
    const bool has_uv = std::all_of(properties.uv.begin(), properties.uv.end(), exists);
    PlyRow row;
    for (std::uint64_t i = 0; i < element.count; ++i) {
        ply.rows.read(element, i, row);
        Double3 point{}, normal{};
        for (std::size_t k = 0; k < 3; ++k) {
            point[k] = row.number(properties.point[k]);
            if (has_normal) normal[k] = row.number(properties.normal[k]);
        }
        std::array<double, 2> uv{};
        if (has_uv) uv = {row.number(properties.uv[0]), row.number(properties.uv[1])};
        if (!is_finite(point)) refuse_ply(ply.source, row.line, reason_not_finite(i, "", point));
        if (!std::isfinite(uv[0]) || !std::isfinite(uv[1]))
            refuse_ply(ply.source, row.line,
                       "the texture coordinates of vertex " + std::to_string(i) +
                           " are not finite; they must be finite numbers");
        append_vertex(ply.mesh, point, has_normal ? normal.data() : nullptr, has_uv ? uv.data() : nullptr);
    }
}

/// Returns a vertex index of face or strip `i`.
std::uint32_t vertex_index(const PlyReader& ply, const PlyRow& row, const char* kind, std::uint64_t i, double index) {
    if (index >= 0 && index < double(ply.vertex_count) && index == std::floor(index))
        return static_cast<std::uint32_t>(index);
    refuse_ply(ply.source, row.line,
               std::string(kind) + ' ' + std::to_string(i) + " has the vertex index " + number_text(index) +
                   ", but its part has only " + std::to_string(ply.vertex_count) + " vertices");
}

/// Appends u and v of the corners of a face, which some programs write as a list of the face.
void read_corner_uv(PlyReader& ply, const PlyRow& row, std::uint64_t face, std::ptrdiff_t property,
                    std::size_t corners) {
    const std::size_t size = property < 0 ? 0 : row.size(property);
    if (size != 0 && size != 2 * corners)
        refuse_ply(ply.source, row.line,
                   "face " + std::to_string(face) + " has " + std::to_string(size) +
                       " numbers in its list texcoord; it must have none, or two for each of its " +
                       std::to_string(corners) + " vertices");
    for (std::size_t k = 0; k < 2 * corners; ++k) {
        const double number = size == 0 ? NAN : row.list(property)[k];
        if (size != 0 && !std::isfinite(number))
            refuse_ply(ply.source, row.line,
                       "the texture coordinates of face " + std::to_string(face) +
                           " are not finite; they must be finite numbers");
        ply.corner_uv.push_back(number);
    }
    ply.has_corner_uv = ply.has_corner_uv || size != 0;
}

void read_faces(PlyReader& ply, const PlyElement& element) {
    if (element.count == 0) return;
    const std::ptrdiff_t indices = find_indices(ply, element);
    std::ptrdiff_t uv = find_property(element, "texcoord");
    if (uv >= 0 && !element.properties[static_cast<std::size_t>(uv)].is_list()) uv = -1;
    PlyRow row;
    for (std::uint64_t i = 0; i < element.count; ++i) {
        ply.rows.read(element, i, row);
        const std::size_t size = row.size(indices);
        const std::string reason = reason_wrong_face_size(i, size);
        if (!reason.empty()) refuse_ply(ply.source, row.line, reason);
        for (std::size_t k = 0; k < size; ++k)
            ply.polygons.corners.push_back(vertex_index(ply, row, "face", i, row.list(indices)[k]));
        ply.polygons.sizes.push_back(static_cast<std::uint32_t>(size));
        if (uv >= 0) read_corner_uv(ply, row, i, uv, size);
    }
}

/// Reads triangle strips. An index of −1 ends a part of a strip.
void read_strips(PlyReader& ply, const PlyElement& element) {
    if (element.count == 0) return;
    const std::ptrdiff_t indices = find_indices(ply, element);
    PlyRow row;
    for (std::uint64_t i = 0; i < element.count; ++i) {
        ply.rows.read(element, i, row);
        for (std::size_t k = 0; k < row.size(indices); ++k) {
            const double index = row.list(indices)[k];
            if (index == -1) ply.strip_ends.push_back(ply.strips.size());
            else ply.strips.push_back(vertex_index(ply, row, "strip", i, index));
        }
        ply.strip_ends.push_back(ply.strips.size());
    }
}

void skip(PlyReader& ply, const PlyElement& element) {
    PlyRow row;
    for (std::uint64_t i = 0; i < element.count; ++i) ply.rows.read(element, i, row);
    if (element.count > 0)
        ply.skipped.push_back(std::to_string(element.count) + " elements " + in_quotes(element.name));
}

/// Creates a vertex for every corner that has its own texture coordinates.
void split_corners(PlyReader& ply) {
    FileMesh& mesh = ply.mesh;
    check_number_of_vertices(ply.source, ply.vertex_count + ply.polygons.corners.size());
    std::size_t without_uv = 0;
    for (std::size_t i = 0; i < ply.polygons.corners.size(); ++i) {
        std::uint32_t& corner = ply.polygons.corners[i];
        const double* uv = &ply.corner_uv[2 * i];
        if (std::isnan(uv[0])) {
            ++without_uv;
            continue;
        }
        const std::size_t k = 3 * std::size_t{corner};
        const Double3 point{mesh.vertices[k], mesh.vertices[k + 1], mesh.vertices[k + 2]};
        const Double3 normal{mesh.normals[k], mesh.normals[k + 1], mesh.normals[k + 2]};
        corner = static_cast<std::uint32_t>(mesh.vertices.size() / 3);
        append_vertex(mesh, point, mesh.has_normals ? normal.data() : nullptr, uv);
    }
    mesh.vertices_without_uv = without_uv;
}

}  // namespace

FileMesh read_ply(const MeshSource& source) {
    const PlyHeader header = read_ply_header(source);
    PlyReader ply{source, PlyRows(source, header)};
    for (const PlyElement& element : header.elements)
        if (element.name == "vertex") ply.vertex_count = element.count;
    check_number_of_vertices(source, ply.vertex_count);
    for (const PlyElement& element : header.elements) {
        if (element.name == "vertex") read_vertices(ply, element);
        else if (element.name == "face") read_faces(ply, element);
        else if (element.name == "tristrips") read_strips(ply, element);
        else if (!element.properties.empty()) skip(ply, element);
    }
    ply.rows.check_end();
    std::string names;
    for (const std::string& name : ply.skipped) append_to_list(names, name);
    if (ply.polygons.sizes.empty() && ply.strips.empty() && !names.empty())
        refuse_ply(source, 0, "the file has no face; " + names + " are not supported. Legal are face and tristrips");
    if (!header.unknown_lines.empty())
        ply.mesh.remarks.push_back(std::to_string(header.unknown_lines.size()) +
                                   " lines of the header are neither declarations nor comments and were left out; the "
                                   "first one is line " +
                                   std::to_string(header.unknown_lines[0]));
    if (!names.empty()) ply.mesh.remarks.push_back(names + " were left out");
    if (ply.has_corner_uv) split_corners(ply);
    append_polygons(ply.mesh, ply.polygons);
    std::size_t start = 0;
    for (const std::size_t end : ply.strip_ends) {
        append_strip(ply.mesh, ply.strips.data() + start, end - start);
        start = end;
    }
    return std::move(ply.mesh);
}

}  // namespace kagero
