/// Building blocks of HTML reports. A page is one self-contained file with styles for light mode, dark mode and print.
#pragma once

#include <string>
#include <vector>

namespace kagero {

/// Escapes &, <, > and " for use between tags and in quoted attributes.
std::string html_text(const std::string& text);

/// Returns a number with two to three significant digits as HTML, such as 0.25, 3.1·10⁻⁷ or 12 400; "–" if it is not
/// finite. Numbers from 1000 to 10⁷ are rounded to whole numbers.
std::string html_number(double value);

/// Returns a table. Cells are HTML. The first `text_columns` columns hold text and are aligned to the left; the others
/// hold numbers.
std::string html_table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows,
                       std::size_t text_columns);

/// Returns a section with a heading, a picture, and a caption that explains how to read it. `svg` is HTML; the other
/// arguments are plain text. Returns "" if `svg` is empty.
std::string html_figure(const std::string& heading, const std::string& svg, const std::string& how_to_read);

/// Returns one box of a `<div class="facts">`: a value and its description, both HTML.
std::string html_fact(const std::string& value, const std::string& description);

/// Returns a complete HTML document. `body` is HTML; title and subtitle are plain text.
std::string html_page(const std::string& title, const std::string& subtitle, const std::string& body);

}  // namespace kagero
