#include "report/text/page.h"

#include "report/text/numbers.h"

#include <charconv>
#include <cmath>

namespace kagero {
namespace {

// Colours are CSS variables, so that charts use the colours of the page in light mode, dark mode and print. In print,
// text is dark and the background is white.
constexpr const char* style = R"css(
:root { color-scheme: light dark; --ink: #1d2430; --soft: #5a6577; --line: #d9dee6; --grid: #e8ebf0; )css"
    R"css(--ground: #ffffff; --panel: #f6f7f9; --mark: #b3261e; --shade: 0%; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e7eaf0; --soft: #9aa5b5; --line: #353d4a; --grid: #262d38; --ground: #14181f; --panel: )css"
    R"css(#1b212a; --mark: #ff8a80; --shade: 12%; }
}
@media print {
  :root { color-scheme: light; --ink: #000; --soft: #444; --line: #bbb; --grid: #e3e3e3; --ground: #fff; )css"
    R"css(--panel: #fff; --mark: #b3261e; --shade: 0%; }
  figure, table, section.keep { break-inside: avoid; }
  details > summary { display: none; }
  body { font-size: 10pt; }
}
* { box-sizing: border-box; }
body { margin: 0; background: var(--ground); color: var(--ink); font: 16px/1.55 system-ui, "Segoe UI", )css"
    R"css(Roboto, "Noto Sans", "DejaVu Sans", sans-serif; }
main { max-width: 62rem; margin: 0 auto; padding: 2.5rem 1.5rem 4rem; }
header { border-bottom: 2px solid var(--ink); margin-bottom: 1.5rem; padding-bottom: .8rem; }
h1 { font-size: 2rem; line-height: 1.2; letter-spacing: -.015em; margin: 0; }
header p { margin: .3rem 0 0; color: var(--soft); }
h2 { font-size: 1.3rem; margin: 2.8rem 0 .5rem; letter-spacing: -.01em; }
p { max-width: 46rem; }
.note { color: var(--soft); font-size: .92rem; }
.facts { display: grid; grid-template-columns: repeat(auto-fit, minmax(13rem, 1fr)); gap: .8rem; margin: 1.2rem 0; }
.facts div { background: var(--panel); border: 1px solid var(--line); border-radius: .5rem; padding: .7rem .9rem; }
.facts b { display: block; font-size: 1.15rem; line-height: 1.3; }
.facts span { color: var(--soft); font-size: .84rem; display: block; }
figure { margin: 1rem 0 1.2rem; }
figure svg { display: block; width: 100%; height: auto; }
figcaption { color: var(--soft); font-size: .92rem; max-width: 46rem; margin-top: .4rem; }
svg text { font: 12px system-ui, "Segoe UI", Roboto, "Noto Sans", "DejaVu Sans", sans-serif; fill: var(--soft); }
svg text.axis { fill: var(--ink); }
svg text.label { font-size: 11.5px; }
svg text.strong { font-weight: 700; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: .88rem; font-variant-numeric: tabular-nums; margin: .6rem 0; )css"
    R"css(width: 100%; }
th, td { padding: .28rem .6rem; text-align: right; border-bottom: 1px solid var(--line); white-space: nowrap; }
th { font-weight: 600; color: var(--soft); border-bottom: 1.5px solid var(--ink); vertical-align: bottom; }
th.word, td.word { text-align: left; white-space: normal; }
td.word { vertical-align: top; }
td.word:first-child { white-space: nowrap; }
.key { white-space: nowrap; margin-right: 1.2em; }
tr:hover td { background: var(--panel); }
details { border-bottom: 1px solid var(--line); padding: .3rem 0; }
summary { cursor: pointer; font-size: .95rem; }
summary small { color: var(--soft); font-size: .86rem; margin-left: .5rem; }
sup { line-height: 0; font-size: .75em; }
code { font: .92em ui-monospace, "DejaVu Sans Mono", monospace; }
footer { margin-top: 3rem; border-top: 1px solid var(--line); padding-top: .8rem; color: var(--soft); )css"
    R"css(font-size: .85rem; }
.bad { color: var(--mark); font-weight: 600; }
)css";

std::string digits(double value, int precision, std::chars_format format) {
    char buffer[40];
    return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value, format, precision).ptr};
}

/// Groups digits in threes with narrow no-break spaces if there are more than four: 12400 → 12 400.
std::string grouped(const std::string& whole) {
    std::string text;
    for (std::size_t i = 0; i < whole.size(); ++i) {
        if (i > 0 && (whole.size() - i) % 3 == 0 && whole.size() > 4) text += "\u202f";
        text += whole[i];
    }
    return text;
}

}  // namespace

std::string html_text(const std::string& text) {
    std::string safe;
    for (const char c : text) switch (c) {
            case '&':
                safe += "&amp;";
                break;
            case '<':
                safe += "&lt;";
                break;
            case '>':
                safe += "&gt;";
                break;
            case '"':
                safe += "&quot;";
                break;
            default:
                safe += c;
        }
    return safe;
}

std::string html_number(double value) {
    if (!std::isfinite(value)) return "–";
    if (value == 0) return "0";
    if (value < 0) return "−" + html_number(-value);
    if (value >= 999.5 && value < 1e7) return grouped(digits(std::round(value), 0, std::chars_format::fixed));
    if (value >= 1e-3 && value < 999.5) return digits(value, 3, std::chars_format::general);
    const std::string text = digits(value, 1, std::chars_format::scientific);
    const std::size_t e = text.find('e');
    const int exponent = std::stoi(text.substr(e + 1));
    const std::string mantissa = text.substr(0, e) == "1.0" ? "" : text.substr(0, e) + "·";
    return mantissa + "10<sup>" + (exponent < 0 ? "−" : "") + std::to_string(std::abs(exponent)) + "</sup>";
}

std::string html_table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows,
                       std::size_t text_columns) {
    const auto line = [&](const std::vector<std::string>& cells, const std::string& tag) {
        std::string text = "<tr>";
        for (std::size_t i = 0; i < cells.size(); ++i)
            text += "<" + tag + (i < text_columns ? " class=\"word\">" : ">") + cells[i] + "</" + tag + ">";
        return text + "</tr>\n";
    };
    std::string text = "<div class=\"scroll\"><table>\n<thead>" + line(head, "th") + "</thead>\n<tbody>\n";
    for (const auto& row : rows) text += line(row, "td");
    return text + "</tbody></table></div>\n";
}

std::string html_figure(const std::string& heading, const std::string& svg, const std::string& how_to_read) {
    if (svg.empty()) return "";
    return "<section class=\"keep\"><h2>" + html_text(heading) + "</h2>\n<figure>" + svg + "<figcaption>" +
           html_text(how_to_read) + "</figcaption></figure></section>\n";
}

std::string html_fact(const std::string& value, const std::string& description) {
    return "<div><b>" + value + "</b><span>" + description + "</span></div>\n";
}

std::string html_page(const std::string& title, const std::string& subtitle, const std::string& body) {
    return "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
           "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
           html_text(title) + "</title>\n<style>" + style + "</style>\n</head>\n<body>\n<main>\n<header><h1>" +
           html_text(title) + "</h1><p>" + html_text(subtitle) + "</p></header>\n" + body +
           "<footer>kagero " KAGERO_VERSION "</footer>\n</main>\n</body>\n</html>\n";
}

}  // namespace kagero
