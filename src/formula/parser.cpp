// Recursive descent, one function per rule of the grammar.
#include "formula/parser.h"

#include "error.h"
#include "formula/lexer.h"
#include "formula/nodes.h"
#include "kernels/operation.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>

namespace kagero {
namespace {

/// The operation that formulas call by this name.
std::optional<Op> function_named(const std::string& name) {
    for (int i = 0; i < op_count; ++i)
        if (operation_infos[i].has_function_name() && name == operation_infos[i].name) return static_cast<Op>(i);
    return std::nullopt;
}

/// The node of a name that a formula has, or −1.
std::int32_t use(FormulaScope& scope, const std::string& name) {
    for (const auto& [known, node] : scope.names) {
        if (known != name) continue;
        scope.used.insert(name);
        return node;
    }
    return -1;
}

class Parser {
public:
    Parser(FormulaScope& scope, const FormulaText& formula)
        : scope_(scope), formula_(formula), tokens_(tokens_of(formula)) {}

    std::int32_t parse() {
        if (now().kind == Token::Kind::end) fail("the formula is empty");
        const std::int32_t root = expression();
        if (now().kind == Token::Kind::end) return root;
        if (is(")")) fail("this ')' has no '('");
        if (is(",")) fail("a ',' stands between the arguments of a function alone; the decimal point is '.'");
        const Token& before = tokens_[next_ - 1];
        const std::string right = now().text;
        fail("an operator is missing: write " + before.text + "*" + right + (is("(") ? "…)" : ""));
    }

private:
    const Token& now() const { return tokens_[next_]; }
    bool is(const char* symbol) const { return now().kind == Token::Kind::symbol && now().text == symbol; }
    bool take(const char* symbol) {
        if (!is(symbol)) return false;
        ++next_;
        return true;
    }
    [[noreturn]] void fail(const std::string& message) const { fail_at(formula_, now().position, message); }

    /// One level of nesting while it lives.
    struct Level {
        explicit Level(Parser& parser) : parser_(parser) {
            if (++parser_.depth_ > greatest_depth)
                parser_.fail("nested deeper than " + std::to_string(greatest_depth) +
                             "; give parts of it names in [space.let]");
        }
        ~Level() { --parser_.depth_; }
        Level(const Level&) = delete;
        Level& operator=(const Level&) = delete;
        Parser& parser_;
    };
    static constexpr int greatest_depth = 200;

    /// Numbers that are not finite, and lists that grow too long, are refused where they arise.
    std::int32_t checked(std::int32_t node, std::size_t position) {
        for (; checked_ < scope_.nodes.size(); ++checked_)
            if (const FormulaNode& n = scope_.nodes[checked_]; n.op == Op::constant && !std::isfinite(n.value))
                fail_at(formula_, position, "this is constant, and not a finite number");
        if (scope_.nodes.size() > formula_limit)
            fail_at(formula_, position,
                    "the formulas of this space are too large: more than " + std::to_string(formula_limit) +
                        " operations");
        return node;
    }

    std::int32_t expression() {
        const Level level(*this);
        std::int32_t sum = term();
        while (is("+") || is("-")) {
            const std::size_t position = now().position;
            const Op op = is("+") ? Op::add : Op::sub;
            ++next_;
            const std::int32_t right = term();
            sum = checked(operation(scope_, op, sum, right), position);
        }
        return sum;
    }
    std::int32_t term() {
        std::int32_t product = factor();
        while (is("*") || is("/")) {
            const std::size_t position = now().position;
            const Op op = is("*") ? Op::mul : Op::div;
            ++next_;
            const std::int32_t right = factor();
            product = checked(operation(scope_, op, product, right), position);
        }
        return product;
    }
    std::int32_t factor() {
        const Level level(*this);
        const std::size_t position = now().position;
        if (take("+")) return factor();
        if (take("-")) return checked(operation(scope_, Op::neg, factor()), position);
        const std::int32_t base = primary();
        if (!is("^")) return base;
        const std::size_t raised = now().position;
        ++next_;
        const std::int32_t exponent = factor();
        return checked(power(scope_, base, exponent), raised);
    }
    std::int32_t primary() {
        const Token token = now();
        if (token.kind == Token::Kind::number)
            return ++next_, checked(number_node(scope_, token.value), token.position);
        if (token.kind == Token::Kind::name) return ++next_, is("(") ? call(token) : named(token);
        if (take("(")) {
            const std::int32_t inside = expression();
            close(token);
            return inside;
        }
        if (token.kind == Token::Kind::end) fail("the formula ends where a number, a name or '(' is expected");
        fail("'" + token.text + "' stands where a number, a name or '(' is expected");
    }
    void close(const Token& opened) {
        if (take(")")) return;
        if (now().kind == Token::Kind::end) fail_at(formula_, opened.position, "this '(' is never closed");
        if (is(",")) fail("a ',' stands between the arguments of a function alone; the decimal point is '.'");
        fail("an operator is missing before " + now().text);
    }
    std::int32_t named(const Token& token) {
        if (const auto function = function_named(token.text)) {
            const char* arguments = info_of(*function).operands == 1 ? "(…)" : "(…, …)";
            fail_at(formula_, token.position, token.text + " is a function: write " + token.text + arguments);
        }
        const std::int32_t node = use(scope_, token.text);
        if (node < 0) fail_unknown(token, false);
        return node;
    }
    std::int32_t call(const Token& token) {
        const std::optional<Op> function = function_named(token.text);
        if (!function && use(scope_, token.text) >= 0)
            fail_at(formula_, token.position,
                    token.text + " is not a function: to multiply write " + token.text + "*(…)");
        if (!function) fail_unknown(token, true);
        const Token opened = now();
        ++next_;
        std::vector<std::int32_t> arguments;
        if (!is(")")) {
            do arguments.push_back(expression());
            while (take(","));
        }
        close({opened.kind, opened.position, opened.text, 0});
        const auto operands = static_cast<std::size_t>(info_of(*function).operands);
        if (arguments.size() != operands)
            fail_at(formula_, token.position,
                    token.text + " takes " + std::to_string(operands) + (operands == 1 ? " argument" : " arguments") +
                        ", not " + std::to_string(arguments.size()));
        const std::int32_t second = arguments.size() > 1 ? arguments[1] : -1;
        return checked(operation(scope_, *function, arguments[0], second), token.position);
    }
    [[noreturn]] void fail_unknown(const Token& token, bool called) const {
        std::vector<std::string> known;
        if (!called)
            for (const auto& entry : scope_.names) known.push_back(entry.first);
        for (const OperationInfo& operation : operation_infos)
            if (operation.has_function_name()) known.emplace_back(operation.name);
        std::string message = std::string(called ? "there is no function " : "unknown name ") + token.text;
        std::string small = token.text, near, list;
        for (char& c : small) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        for (const std::string& name : known) {
            enumerate(list, name);
            if (name == small) near = name;
        }
        if (near.empty()) near = near_match(token.text, known);
        if (!called && formula_.name == "space.let." + token.text) message += ", which is what is being defined";
        message += near.empty() ? "; known: " : "; did you mean " + near + "? Known: ";
        fail_at(formula_, token.position, message + list);
    }

    FormulaScope& scope_;
    const FormulaText& formula_;
    std::vector<Token> tokens_;
    std::size_t next_ = 0, checked_ = scope_.nodes.size();
    int depth_ = 0;
};

}  // namespace

std::int32_t parse_formula(FormulaScope& scope, const FormulaText& formula) {
    constexpr std::size_t greatest_length = 65536;
    if (formula.text.size() > greatest_length)
        throw InputError(formula.place,
                         formula.name + ": the formula is longer than " + std::to_string(greatest_length) + " bytes");
    return Parser(scope, formula).parse();
}

void define(FormulaScope& scope, const std::string& name, std::int32_t node, const Place& place) {
    const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
    const auto inside = [&](char c) { return letter(c) || (c >= '0' && c <= '9'); };
    if (name.empty() || !letter(name[0]) || !std::all_of(name.begin(), name.end(), inside))
        throw InputError(place,
                         "'" + name +
                             "' is no name for formulas: names are letters, digits and _, and begin with no digit");
    if (function_named(name)) throw InputError(place, "'" + name + "' is a function of formulas: choose another name");
    if (use(scope, name) >= 0)
        throw InputError(place, "'" + name + "' has a meaning in formulas already: choose another name");
    scope.names.emplace_back(name, node);
}

}  // namespace kagero
