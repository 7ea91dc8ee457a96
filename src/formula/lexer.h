/// Formulas as tokens.
#pragma once

#include "formula/formula.h"

namespace kagero {

struct Token {
    enum class Kind { number, name, symbol, end };
    Kind kind;
    std::size_t position;  ///< of its first byte
    std::string text;      ///< of a symbol one of + - * / ^ ( ) ,
    double value = 0;
};

/// Throws for characters and numbers that no formula has. The last token is `end`.
std::vector<Token> tokens_of(const FormulaText& formula);

/// Throws InputError: the key, the position, what is wrong, the line and a caret below it.
[[noreturn]] void fail_at(const FormulaText& formula, std::size_t position, const std::string& message);

}  // namespace kagero
