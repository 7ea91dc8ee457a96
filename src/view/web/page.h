/// The files of the page, which are part of the program (view/page/).
#pragma once

#include "view/web/web_server.h"

namespace kagero {

/// Returns the answer with the file of the page at a path such as "/view.js"; nothing if there is no such file. In the
/// HTML file, @TOKEN@ is replaced by the token.
std::optional<WebResponse> page_file(const std::string& path, const std::string& token);

}  // namespace kagero
