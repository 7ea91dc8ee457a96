/// Types and functions that the readers of all mesh formats share: the bytes of a file, its mesh, and its errors.
#pragma once

#include "error.h"
#include "geometry/files/file_material.h"
#include "scene/vector3.h"

#include <cstdint>
#include <string_view>

namespace kagero {

/// A mesh file whose bytes have been read.
struct MeshSource {
    std::string path;
    std::string bytes;
    std::string used_by;  ///< Key of the scene that names the file, with its location. Messages end with it.
    bool reads_materials = false;  ///< True if the materials of the file are read.
};

/// Mesh in the coordinates of its file, with counts of data that is missing or left out. The arrays `normals` and `uv`
/// have entries for every vertex; normals need not have unit length.
struct FileMesh {
    std::vector<double> vertices;              ///< Three coordinates per vertex.
    std::vector<std::uint32_t> triangles;      ///< Three vertex indices per triangle. All are in range.
    std::vector<double> normals;               ///< Zero for vertices without a normal.
    std::vector<double> uv;                    ///< Zero for vertices without texture coordinates.
    bool has_normals = false, has_uv = false;  ///< True if any vertex has a normal or texture coordinates.
    std::size_t points_and_lines = 0;          ///< Number of points and lines, which are left out.
    std::size_t vertices_without_uv = 0;       ///< Number of vertices without texture coordinates.
    std::vector<std::string> remarks;          ///< Messages about other data that is left out.
    std::vector<FileMaterial> materials;       ///< Materials that triangles use, if they are read; else none.
    std::vector<std::uint32_t> material_of_triangle;  ///< Index of the material of each triangle, if they are read.
};

/// Refuses a file: throws InputError with its path, a line (0 if unknown) and the key of the scene that names it.
[[noreturn]] void refuse_file(const MeshSource& source, std::size_t line, const std::string& message);

/// Returns text of a file for messages: in quotation marks, at most 40 characters, without unprintable bytes.
std::string in_quotes(std::string_view text);

/// Reads a word as a number and returns true, or returns false if it is not a number. A number beyond the range of
/// `double` is read as infinity.
bool parse_number(std::string_view word, double& number);

/// Returns the text of a number, with the digits that identify it.
std::string number_text(double number);

bool is_finite(const Double3& vector);

/// Returns the reason why a vertex that is not finite is refused. `part` is the name of the vertex's part of the file.
std::string reason_not_finite(std::size_t vertex, const std::string& part, const Double3& point);

/// Appends a vertex. A null pointer stands for a normal or for texture coordinates that are missing. A normal that is
/// not finite is stored as zero; shading then uses the normal of the triangle.
void append_vertex(FileMesh& mesh, const Double3& point, const double* normal, const double* uv);

/// Returns the triangles that have a material, with the vertices that they use. The remarks and counts of the file are
/// only in the first part.
FileMesh part_of(const FileMesh& mesh, std::uint32_t material);

/// Refuses a file with more vertices than indices of 32 bits can address.
void check_number_of_vertices(const MeshSource& source, std::uint64_t count);

/// Returns the reason why a face with so many corners is refused, or "" if it is legal.
std::string reason_wrong_face_size(std::size_t face, std::size_t corners);

}  // namespace kagero
