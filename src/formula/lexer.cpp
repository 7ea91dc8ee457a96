#include "formula/lexer.h"

#include <algorithm>
#include <charconv>

namespace kagero {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool starts_name(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
/// Returns true if c is a byte of a UTF-8 character other than the first.
bool continues_character(char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; }

/// Returns the number of UTF-8 characters in the bytes from `first` to `position`.
std::size_t count_characters(const std::string& text, std::size_t first, std::size_t position) {
    std::size_t count = 0;
    for (std::size_t i = first; i < position; ++i) count += !continues_character(text[i]);
    return count;
}

/// Throws InputError for an invalid character. The message proposes a replacement for common mathematical symbols.
[[noreturn]] void fail_at_character(const FormulaText& formula, std::size_t at) {
    const std::string& text = formula.text;
    std::size_t end = at + 1;
    while (end < text.size() && continues_character(text[end])) ++end;
    const std::string character = text.substr(at, end - at);
    static const std::pair<const char*, const char*> replacements[] = {{"\u2212", "-"},  {"\u00b7", "*"},
                                                                {"\u00d7", "*"},  {"\u00f7", "/"},
                                                                {"\u00b2", "^2"}, {"\u00b3", "^3"},
                                                                {"\u03c0", "pi"}, {"\u221a", "sqrt( )"},
                                                                {"|", "abs( )"},  {"[", "("},
                                                                {"]", ")"},       {"{", "("},
                                                                {"}", ")"},       {";", ","}};
    std::string message = "'" + character + "' is not allowed in a formula";
    const unsigned char byte = static_cast<unsigned char>(text[at]);
    if (byte < 0x20 || byte == 0x7f) message = "a control character is not allowed in a formula";
    for (const auto& [symbol, replacement] : replacements)
        if (character == symbol) message += std::string("; write ") + replacement;
    fail_at(formula, at, message);
}

/// Returns the number that begins at this position.
Token number_at(const FormulaText& formula, std::size_t at) {
    const std::string& text = formula.text;
    Token token{Token::Kind::number, at, "", 0};
    const char *first = text.data() + at, *last = text.data() + text.size();
    const auto [end, error] = std::from_chars(first, last, token.value);
    if (error == std::errc::result_out_of_range)
        fail_at(formula, at, "this number is too large or too small for double precision");
    if (error != std::errc()) fail_at(formula, at, "'.' is not a number; a digit must precede or follow it");
    token.text.assign(first, end);
    if (end != last && (*end == '.' || is_digit(*end)))
        fail_at(formula, static_cast<std::size_t>(end - text.data()), "a number has at most one decimal point");
    if (end != last && (*end == 'e' || *end == 'E')) {
        const char* next = end + 1;
        if (next == last || is_blank(*next) || *next == '+' || *next == '-')
            fail_at(formula, static_cast<std::size_t>(end - text.data()), "the exponent of this number is missing");
    }
    return token;
}

}  // namespace

void fail_at(const FormulaText& formula, std::size_t position, const std::string& message) {
    const std::string& text = formula.text;
    position = std::min(position, text.size());
    const std::size_t before = position ? text.rfind('\n', position - 1) : std::string::npos;
    const std::size_t first = before == std::string::npos ? 0 : before + 1;
    const std::size_t last = std::min(text.find('\n', position), text.size());
    // Only the part of a long line around the position is shown.
    constexpr std::size_t max_context = 60;
    std::size_t left = position - first > max_context ? position - max_context : first;
    std::size_t right = std::min(last, position + max_context);
    while (left > first && continues_character(text[left])) --left;
    while (right < last && continues_character(text[right])) ++right;
    std::string line = text.substr(left, right - left);
    for (char& c : line)
        if (static_cast<unsigned char>(c) < 0x20) c = ' ';
    const std::string caret = std::string(count_characters(text, left, position), ' ') + '^';
    const std::string where = std::to_string(count_characters(text, 0, position) + 1);
    throw InputError(formula.location, formula.name + ", position " + where + ": " + message + "\n    " + line +
                                        "\n    " + caret);
}

std::vector<Token> tokenize(const FormulaText& formula) {
    const std::string& text = formula.text;
    std::vector<Token> tokens;
    for (std::size_t at = 0; at < text.size();) {
        const char c = text[at];
        if (is_blank(c)) {
            ++at;
        } else if (is_digit(c) || c == '.') {
            tokens.push_back(number_at(formula, at));
            at += tokens.back().text.size();
        } else if (starts_name(c)) {
            std::size_t end = at + 1;
            while (end < text.size() && (starts_name(text[end]) || is_digit(text[end]))) ++end;
            tokens.push_back({Token::Kind::name, at, text.substr(at, end - at), 0});
            at = end;
        } else if (std::string("+-*/^(),").find(c) != std::string::npos && c != '\0') {
            if (c == '*' && at + 1 < text.size() && text[at + 1] == '*')
                fail_at(formula, at, "'**' is not an operator of formulas; write ^");
            tokens.push_back({Token::Kind::symbol, at++, std::string(1, c), 0});
        } else {
            fail_at_character(formula, at);
        }
    }
    tokens.push_back({Token::Kind::end, text.size(), "", 0});
    return tokens;
}

}  // namespace kagero
