/// Splits the text of a formula into tokens.
#pragma once

#include "formula/formula.h"

namespace kagero {

/// One token of a formula.
struct Token {
    enum class Kind { number, name, symbol, end };
    Kind kind;
    std::size_t position;  ///< Index of the first byte in the text of the formula.
    std::string text;      ///< A symbol is one of + - * / ^ ( ) ,
    double value = 0;      ///< Value of a number.
};

/// Returns the tokens of a formula; the last one is `end`. Throws InputError for an invalid character or number.
std::vector<Token> tokenize(const FormulaText& formula);

/// Throws InputError. The message contains the key of the formula, the position in characters, `message`, and the line
/// of the formula with a caret below the position. `position` is a byte index in the text of the formula.
[[noreturn]] void fail_at(const FormulaText& formula, std::size_t position, const std::string& message);

}  // namespace kagero
