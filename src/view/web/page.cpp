#include "view/web/page.h"

#include <iterator>
#include <string_view>

namespace kagero {
namespace {

/// A file of the page.
struct PageFile {
    const char *path, *type;
    std::string_view text;
};

// The build writes the contents of the files as string literals.
constexpr PageFile page_files[] = {
#include "page_files.inc"
};

std::string with_token(std::string_view text, const std::string& token) {
    constexpr std::string_view mark = "@TOKEN@";
    std::string result(text);
    for (std::size_t at; (at = result.find(mark)) != std::string::npos;) result.replace(at, mark.size(), token);
    return result;
}

}  // namespace

std::optional<WebResponse> page_file(const std::string& path, const std::string& token) {
    for (const PageFile& file : page_files) {
        if (path != file.path) continue;
        const bool is_html = std::string_view(file.type).starts_with("text/html");
        return text_response(200, is_html ? with_token(file.text, token) : std::string(file.text), file.type);
    }
    return {};
}

}  // namespace kagero
