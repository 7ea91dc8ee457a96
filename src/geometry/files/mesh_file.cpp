#include "geometry/files/mesh_file.h"

#include "scene/value.h"

#include <algorithm>
#include <charconv>

namespace kagero {

namespace {

/// Maximum number of corners of a face. The triangulation of a face with so many corners takes seconds; its time grows
/// with the square of the number.
constexpr std::size_t max_corners = 30000;

/// Maximum number of vertices of a mesh, so that an index fits into 32 bits.
constexpr std::uint64_t max_vertices = std::uint64_t{1} << 31;

}  // namespace

void refuse_file(const MeshSource& source, std::size_t line, const std::string& message) {
    throw InputError({source.path, static_cast<int>(std::min<std::size_t>(line, 2147483647)), 0},
                     message + " (the file is named by " + source.used_by + ")");
}

std::string in_quotes(std::string_view text) {
    constexpr std::size_t max_length = 40;
    std::string printable(text.substr(0, max_length));
    for (char& letter : printable) {
        if (letter < ' ' || letter > '~') letter = '?';
    }
    return '"' + printable + (text.size() > max_length ? "…\"" : "\"");
}

bool parse_number(std::string_view word, double& number) {
    if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);
    const char* end = word.data() + word.size();
    const auto result = std::from_chars(word.data(), end, number);
    if (result.ec == std::errc{}) return result.ptr == end;
    if (result.ec != std::errc::result_out_of_range || result.ptr != end) return false;
    // The number is too small or too large for double. The wider type distinguishes these cases.
    constexpr double greatest = std::numeric_limits<double>::max();
    long double wide = std::numeric_limits<long double>::infinity();
    std::from_chars(word.data(), end, wide);
    const bool is_large = std::abs(wide) > greatest;
    number = is_large ? std::copysign(HUGE_VAL, wide < 0 ? -1.0 : 1.0) : static_cast<double>(wide);
    return true;
}

std::string number_text(double number) {
    constexpr double greatest_exact = 9007199254740992;  // 2^53; smaller whole numbers are written without a point
    if (std::abs(number) < greatest_exact && number == std::floor(number))
        return std::to_string(static_cast<long long>(number));
    return to_toml(number);
}

bool is_finite(const Double3& vector) {
    return std::isfinite(vector[0]) && std::isfinite(vector[1]) && std::isfinite(vector[2]);
}

std::string reason_not_finite(std::size_t vertex, const std::string& part, const Double3& point) {
    std::size_t axis = 0;
    while (axis < 2 && std::isfinite(point[axis])) ++axis;
    return "vertex " + std::to_string(vertex) + " of part " + in_quotes(part) + " is not finite: " + "xyz"[axis] +
           " = " + number_text(point[axis]) + "; all coordinates must be finite numbers";
}

void append_vertex(FileMesh& mesh, const Double3& point, const double* normal, const double* uv) {
    mesh.vertices.insert(mesh.vertices.end(), point.begin(), point.end());
    const Double3 stored = normal ? Double3{normal[0], normal[1], normal[2]} : Double3{};
    for (const double component : stored) mesh.normals.push_back(is_finite(stored) ? component : 0);
    mesh.uv.push_back(uv ? uv[0] : 0);
    mesh.uv.push_back(uv ? uv[1] : 0);
    mesh.has_normals = mesh.has_normals || normal;
    mesh.has_uv = mesh.has_uv || uv;
    if (!uv) ++mesh.vertices_without_uv;
}

FileMesh part_of(const FileMesh& mesh, std::uint32_t material) {
    constexpr std::uint32_t unused = ~std::uint32_t{0};
    FileMesh part;
    std::vector<std::uint32_t> new_index(mesh.vertices.size() / 3, unused);
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        if (mesh.material_of_triangle[i / 3] != material) continue;
        const std::uint32_t old = mesh.triangles[i];
        if (new_index[old] == unused) {
            new_index[old] = static_cast<std::uint32_t>(part.vertices.size() / 3);
            const auto v = mesh.vertices.begin() + 3 * std::ptrdiff_t(old),
                       n = mesh.normals.begin() + 3 * std::ptrdiff_t(old),
                       uv = mesh.uv.begin() + 2 * std::ptrdiff_t(old);
            part.vertices.insert(part.vertices.end(), v, v + 3);
            part.normals.insert(part.normals.end(), n, n + 3);
            part.uv.insert(part.uv.end(), uv, uv + 2);
        }
        part.triangles.push_back(new_index[old]);
    }
    part.has_normals = mesh.has_normals;
    part.has_uv = mesh.has_uv;
    if (material != mesh.material_of_triangle.front()) return part;
    part.points_and_lines = mesh.points_and_lines;
    part.vertices_without_uv = mesh.vertices_without_uv;
    part.remarks = mesh.remarks;
    return part;
}

void check_number_of_vertices(const MeshSource& source, std::uint64_t count) {
    if (count > max_vertices)
        refuse_file(source, 0, "the file has " + std::to_string(count) + " vertices; the limit is 2^31");
}

std::string reason_wrong_face_size(std::size_t face, std::size_t corners) {
    const std::string name = "face " + std::to_string(face);
    if (corners == 0) return name + " has no vertices; at least one is required";
    if (corners <= max_corners) return "";
    return name + " has " + std::to_string(corners) + " vertices; the limit is " + std::to_string(max_corners) +
           ". Divide the face into smaller ones";
}

}  // namespace kagero
