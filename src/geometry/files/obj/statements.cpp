#include "geometry/files/obj/statements.h"

#include <algorithm>
#include <utility>

namespace kagero {

namespace {

struct Keyword {
    const char* word;
    ObjKind kind;
};

/// The keywords of the OBJ format, version 3.0. `fo` is an old form of `f`.
constexpr Keyword keywords[] = {
    {"v", ObjKind::vertex},         {"vt", ObjKind::texture_coordinates},
    {"vn", ObjKind::normal},        {"f", ObjKind::face},
    {"fo", ObjKind::face},          {"l", ObjKind::line},
    {"p", ObjKind::point},          {"o", ObjKind::name},
    {"g", ObjKind::name},           {"usemtl", ObjKind::name},
    {"mtllib", ObjKind::name},      {"usemap", ObjKind::name},
    {"maplib", ObjKind::name},      {"shadow_obj", ObjKind::name},
    {"trace_obj", ObjKind::name},   {"s", ObjKind::ignored},
    {"mg", ObjKind::ignored},       {"bevel", ObjKind::ignored},
    {"lod", ObjKind::ignored},      {"c_interp", ObjKind::ignored},
    {"d_interp", ObjKind::ignored}, {"ctech", ObjKind::ignored},
    {"stech", ObjKind::ignored},    {"vp", ObjKind::ignored},
    {"cstype", ObjKind::ignored},   {"deg", ObjKind::ignored},
    {"bmat", ObjKind::ignored},     {"step", ObjKind::ignored},
    {"parm", ObjKind::ignored},     {"trim", ObjKind::ignored},
    {"hole", ObjKind::ignored},     {"scrv", ObjKind::ignored},
    {"sp", ObjKind::ignored},       {"end", ObjKind::ignored},
    {"con", ObjKind::ignored},      {"curv", ObjKind::surface},
    {"curv2", ObjKind::surface},    {"surf", ObjKind::surface},
    {"bsp", ObjKind::surface},      {"bzp", ObjKind::surface},
    {"cdc", ObjKind::surface},      {"cdp", ObjKind::surface},
    {"res", ObjKind::surface},      {"call", ObjKind::surface},
    {"csh", ObjKind::surface},
};

ObjKind kind_of(std::string_view word) {
    for (const Keyword& keyword : keywords)
        if (word == keyword.word) return keyword.kind;
    return ObjKind::unknown;
}

bool is_blank(char c) { return static_cast<unsigned char>(c) <= ' '; }

/// Removes the first word of a text and returns it. The result is empty if the text is blank.
std::string_view take_word(std::string_view& text) {
    const auto start = std::find_if_not(text.begin(), text.end(), is_blank);
    const auto end = std::find_if(start, text.end(), is_blank);
    const std::string_view word(start, end);
    text = {end, text.end()};
    return word;
}

/// Converts UTF-16 to text in which every character outside ASCII is a question mark. Such characters occur only in
/// names and comments.
std::string from_utf16(std::string_view bytes, bool big_endian) {
    std::string text;
    for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) {
        const char high = bytes[big_endian ? i : i + 1], low = bytes[big_endian ? i + 1 : i];
        text += high == 0 && (low & 0x80) == 0 ? low : '?';
    }
    return text;
}

}  // namespace

std::string name_in(const ObjStatement& statement) {
    if (statement.words.size() < 2) return "";
    return {statement.words[1].data(), statement.words.back().data() + statement.words.back().size()};
}

std::vector<std::string> obj_keywords() {
    std::vector<std::string> words;
    for (const Keyword& keyword : keywords) words.push_back(keyword.word);
    return words;
}

ObjStatements::ObjStatements(std::string_view bytes) : rest_(bytes) {
    const bool little_endian = bytes.starts_with("\xff\xfe"), big_endian = bytes.starts_with("\xfe\xff");
    if (little_endian || big_endian) {
        converted_ = from_utf16(bytes.substr(2), big_endian);
        rest_ = converted_;
    } else if (bytes.starts_with("\xef\xbb\xbf")) {
        rest_.remove_prefix(3);
    }
}

std::string_view ObjStatements::next_line() {
    const std::size_t end = std::min(rest_.find_first_of("\r\n"), rest_.size());
    const std::string_view line = rest_.substr(0, end);
    const std::size_t separator = rest_.substr(end).starts_with("\r\n") ? 2 : 1;
    rest_.remove_prefix(std::min(end + separator, rest_.size()));
    ++line_;
    return line;
}

bool ObjStatements::next_line_begins_with_keyword() const {
    std::string_view line = rest_.substr(0, rest_.find_first_of("\r\n"));
    const std::string_view word = take_word(line);
    return word.empty() || word.starts_with('#') || kind_of(word) != ObjKind::unknown;
}

bool ObjStatements::next(ObjStatement& statement) {
    statement.words.clear();
    while (!rest_.empty()) {
        std::string_view line = next_line();
        if (statement.words.empty()) statement.line = line_;
        const std::size_t comment = line.find('#');
        line = line.substr(0, comment);
        while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
        bool continues = comment == std::string_view::npos && line.ends_with('\\');
        std::string_view words = continues ? line.substr(0, line.size() - 1) : line;
        for (std::string_view word = take_word(words); !word.empty(); word = take_word(words)) {
            if (statement.words.empty()) statement.kind = kind_of(word);
            statement.words.push_back(word);
        }
        // A name can end with a backslash, as in `mtllib c:\models\`. It continues only in a line that is no statement.
        if (continues && !statement.words.empty() && statement.kind == ObjKind::name)
            continues = !next_line_begins_with_keyword();
        if (!continues && !statement.words.empty()) return true;
    }
    return !statement.words.empty();
}

}  // namespace kagero
