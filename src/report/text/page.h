/// The frame of a report: one HTML file that needs nothing else, readable in light, in the dark and on paper.
#pragma once

#include <string>
#include <vector>

namespace kagero {

/// For text between tags and in quoted attributes.
std::string html_text(const std::string& text);

/// A number to a few digits: 0.25, 3.1×10⁻⁷, 12 400.
std::string html_number(double value);

/// Rows of cells that are HTML already; the first `text_columns` of them are words, the others numbers.
std::string html_table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows,
                       std::size_t text_columns);

/// A picture under a heading, with a sentence on how to read it; `svg` is HTML already, and where it is empty so is the
/// figure.
std::string html_figure(const std::string& heading, const std::string& svg, const std::string& how_to_read);

/// One tile of a `<div class="facts">`: a value and what it is; both are HTML already.
std::string html_fact(const std::string& value, const std::string& what);

/// `body` is HTML; the other two are plain text.
std::string html_page(const std::string& title, const std::string& subtitle, const std::string& body);

}  // namespace kagero
