/// Statements of OBJ files: logical lines, divided into words.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace kagero {

/// The kinds of statements, by their effect on a mesh of triangles.
enum class ObjKind {
    vertex,
    texture_coordinates,
    normal,
    face,
    line,
    point,
    name,     ///< The arguments are names, which can contain any letter.
    ignored,  ///< Attributes without effect on a mesh.
    surface,  ///< Geometry that is not supported, such as a free-form surface.
    unknown
};

/// A keyword and its arguments.
struct ObjStatement {
    ObjKind kind = ObjKind::unknown;
    std::vector<std::string_view> words;  ///< The first word is the keyword.
    std::size_t line = 0;                 ///< Number of the line in which the statement begins.
};

/// Returns the text from the second word of a statement to its end: a name that may contain spaces.
std::string name_in(const ObjStatement& statement);

/// Returns all keywords of OBJ files.
std::vector<std::string> obj_keywords();

/// Divides the text of an OBJ file into statements. Lines end with LF, CR or CRLF. A backslash at the end of a line
/// joins it to the next one, except in a comment. A byte order mark is skipped, and UTF-16 is converted.
class ObjStatements {
public:
    explicit ObjStatements(std::string_view bytes);

    /// Reads the next statement. Returns false at the end of the file. The words are valid as long as this object.
    bool next(ObjStatement& statement);

private:
    std::string_view next_line();
    bool next_line_begins_with_keyword() const;

    std::string converted_;  ///< The text, if the file is in UTF-16.
    std::string_view rest_;  ///< The text that has not been read.
    std::size_t line_ = 0;   ///< Number of lines read so far.
};

}  // namespace kagero
