// Recursive-descent parser. The functions expression, term, factor and primary implement the rules of the grammar in
// parser.h; `factor` includes the rule `power`.
#include "formula/parser.h"

#include "error.h"
#include "formula/lexer.h"
#include "formula/nodes.h"
#include "formula/textbook_coordinates.h"
#include "kernels/operation.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>

namespace kagero {
namespace {

/// The function of three arguments whose nodes are gates. Every other function is one operation.
constexpr const char* branch_function = "where";

/// Returns the operation with this function name; for `branch_function`, its first gate.
std::optional<Op> function_named(const std::string& name) {
    if (name == branch_function) return Op::if_positive;
    for (int i = 0; i < op_count; ++i)
        if (operation_infos[i].has_function_name() && name == operation_infos[i].name) return static_cast<Op>(i);
    return std::nullopt;
}

/// Returns the number of arguments of a function.
std::size_t argument_count(Op function) {
    return is_gate(function) ? 3 : static_cast<std::size_t>(info_of(function).operands);
}

/// Returns the node of a name and records that the name is used. Names of the scene precede those of textbook
/// variables. Returns −1 if the name is not defined.
std::int32_t look_up(FormulaScope& scope, const std::string& name) {
    for (const auto& [known, node] : scope.names) {
        if (known != name) continue;
        scope.used_names.insert(name);
        return node;
    }
    return textbook_node(scope, name);
}

class Parser {
public:
    Parser(FormulaScope& scope, const FormulaText& formula)
        : scope_(scope), formula_(formula), tokens_(tokenize(formula)) {}

    /// Returns the root of the formula. If `cartesian` is true, the textbook variables are replaced.
    std::int32_t parse(bool cartesian) {
        if (current().kind == Token::Kind::end) fail("the formula is empty");
        const std::int32_t node = expression();
        if (current().kind == Token::Kind::end) return cartesian ? check_nodes(to_cartesian(scope_, node), 0) : node;
        if (is(")")) fail("this ')' has no matching '('");
        if (is(",")) fail("a ',' is allowed only between the arguments of a function; the decimal point is '.'");
        const Token& left = tokens_[next_token_ - 1];
        const std::string right = current().text;
        fail("an operator is missing: write " + left.text + "*" + right + (is("(") ? "…)" : ""));
    }

private:
    const Token& current() const { return tokens_[next_token_]; }
    bool is(const char* symbol) const { return current().kind == Token::Kind::symbol && current().text == symbol; }
    bool accept(const char* symbol) {
        if (!is(symbol)) return false;
        ++next_token_;
        return true;
    }
    [[noreturn]] void fail(const std::string& message) const { fail_at(formula_, current().position, message); }

    /// Increments the nesting depth during its lifetime. The constructor throws InputError if the limit is exceeded.
    struct NestingGuard {
        explicit NestingGuard(Parser& parser) : parser_(parser) {
            if (++parser_.depth_ > max_depth)
                parser_.fail("the formula has more than " + std::to_string(max_depth) +
                             " levels of nesting; define parts of it in the table `let`");
        }
        ~NestingGuard() { --parser_.depth_; }
        NestingGuard(const NestingGuard&) = delete;
        NestingGuard& operator=(const NestingGuard&) = delete;
        Parser& parser_;
    };
    static constexpr int max_depth = 200;

    /// Throws InputError if a new constant is not finite or if there are too many nodes. Otherwise returns `node`.
    std::int32_t check_nodes(std::int32_t node, std::size_t position) {
        for (; checked_count_ < scope_.nodes.size(); ++checked_count_)
            if (const FormulaNode& n = scope_.nodes[checked_count_]; n.op == Op::constant && !std::isfinite(n.value))
                fail_at(formula_, position, "the value of this constant expression is not a finite number");
        if (scope_.nodes.size() > max_formula_nodes)
            fail_at(formula_, position,
                    "the formulas of this space are too large: they have more than " +
                        std::to_string(max_formula_nodes) + " operations");
        return node;
    }

    std::int32_t expression() {
        const NestingGuard guard(*this);
        std::int32_t sum = term();
        while (is("+") || is("-")) {
            const std::size_t position = current().position;
            const Op op = is("+") ? Op::add : Op::sub;
            ++next_token_;
            const std::int32_t right = term();
            sum = check_nodes(operation(scope_, op, sum, right), position);
        }
        return sum;
    }
    std::int32_t term() {
        std::int32_t product = factor();
        while (is("*") || is("/")) {
            const std::size_t position = current().position;
            const Op op = is("*") ? Op::mul : Op::div;
            ++next_token_;
            const std::int32_t right = factor();
            product = check_nodes(operation(scope_, op, product, right), position);
        }
        return product;
    }
    std::int32_t factor() {
        const NestingGuard guard(*this);
        const std::size_t position = current().position;
        if (accept("+")) return factor();
        if (accept("-")) return check_nodes(operation(scope_, Op::neg, factor()), position);
        const std::int32_t base = primary();
        if (!is("^")) return base;
        const std::size_t caret_position = current().position;
        ++next_token_;
        const std::int32_t exponent = factor();
        return check_nodes(power(scope_, base, exponent), caret_position);
    }
    std::int32_t primary() {
        const Token token = current();
        if (token.kind == Token::Kind::number)
            return ++next_token_, check_nodes(number_node(scope_, token.value), token.position);
        if (token.kind == Token::Kind::name) return ++next_token_, is("(") ? call(token) : named(token);
        if (accept("(")) {
            const std::int32_t inside = expression();
            expect_close(token);
            return inside;
        }
        if (token.kind == Token::Kind::end) fail("the formula ends where a number, a name or '(' is expected");
        fail("'" + token.text + "' is written where a number, a name or '(' is expected");
    }
    /// Reads the ')' that closes the bracket `opened`.
    void expect_close(const Token& opened) {
        if (accept(")")) return;
        if (current().kind == Token::Kind::end) fail_at(formula_, opened.position, "this '(' is never closed");
        if (is(",")) fail("a ',' is allowed only between the arguments of a function; the decimal point is '.'");
        fail("an operator is missing before " + current().text);
    }
    /// Returns the node of a name that is not followed by '('.
    std::int32_t named(const Token& token) {
        if (const auto function = function_named(token.text)) {
            const char* const by_count[] = {"(…)", "(…, …)", "(…, …, …)"};
            const char* arguments = by_count[argument_count(*function) - 1];
            fail_at(formula_, token.position, token.text + " is a function; write " + token.text + arguments);
        }
        const std::int32_t node = look_up(scope_, token.text);
        if (node < 0) fail_unknown(token, false);
        return node;
    }
    /// Reads the arguments of a function and returns the node of its result.
    std::int32_t call(const Token& token) {
        const std::optional<Op> function = function_named(token.text);
        if (!function && look_up(scope_, token.text) >= 0)
            fail_at(formula_, token.position,
                    token.text + " is not a function; to multiply, write " + token.text + "*(…)");
        if (!function) fail_unknown(token, true);
        const Token opened = current();
        ++next_token_;
        std::vector<std::int32_t> arguments;
        if (!is(")")) {
            do arguments.push_back(expression());
            while (accept(","));
        }
        expect_close({opened.kind, opened.position, opened.text, 0});
        const std::size_t count = argument_count(*function);
        if (arguments.size() != count)
            fail_at(formula_, token.position,
                    token.text + " takes " + std::to_string(count) + (count == 1 ? " argument" : " arguments") +
                        ", not " + std::to_string(arguments.size()));
        if (count == 3) return check_nodes(branch(scope_, arguments[0], arguments[1], arguments[2]), token.position);
        const std::int32_t second = arguments.size() > 1 ? arguments[1] : -1;
        return check_nodes(operation(scope_, *function, arguments[0], second), token.position);
    }
    /// Throws InputError for an unknown name. `called` is true if '(' follows the name.
    [[noreturn]] void fail_unknown(const Token& token, bool called) const {
        std::vector<std::string> known;
        const auto is_legal = [&](unsigned variables) { return !called && !(variables & ~formula_.allowed); };
        for (const auto& [name, node] : scope_.names)
            if (is_legal(scope_.variables[static_cast<std::size_t>(node)] & ~FormulaScope::textbook_bit))
                known.push_back(name);
        for (const TextbookVariable& variable : textbook_variables)
            if (is_legal(variable.depends_on)) known.emplace_back(variable.name);
        for (const OperationInfo& operation : operation_infos)
            if (operation.has_function_name()) known.emplace_back(operation.name);
        known.emplace_back(branch_function);
        std::string message = std::string(called ? "there is no function " : "unknown name ") + token.text;
        std::string lower_case = token.text, near, list;
        for (char& c : lower_case) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        for (const std::string& name : known) {
            append_to_list(list, name);
            if (name == lower_case) near = name;
        }
        if (near.empty()) near = near_match(token.text, known);
        if (!called && formula_.name.ends_with(".let." + token.text))
            message += ", because a helper cannot use the name that it defines";
        message += near.empty() ? "; legal names: " : "; did you mean " + near + "? Legal names: ";
        fail_at(formula_, token.position, message + list);
    }

    FormulaScope& scope_;
    const FormulaText& formula_;
    std::vector<Token> tokens_;
    std::size_t next_token_ = 0;
    std::size_t checked_count_ = scope_.nodes.size();  ///< Number of nodes that `check_nodes` has checked.
    int depth_ = 0;  ///< Current depth of nesting.
};

}  // namespace

namespace {

std::int32_t parse_text(FormulaScope& scope, const FormulaText& formula, bool cartesian) {
    constexpr std::size_t max_length = 65536;
    if (formula.text.size() > max_length)
        throw InputError(formula.location,
                         formula.name + ": the formula is longer than " + std::to_string(max_length) + " bytes");
    return Parser(scope, formula).parse(cartesian);
}

}  // namespace

std::int32_t parse_formula(FormulaScope& scope, const FormulaText& formula) {
    return parse_text(scope, formula, true);
}

std::int32_t parse_helper(FormulaScope& scope, const FormulaText& formula) { return parse_text(scope, formula, false); }

void define(FormulaScope& scope, const std::string& name, std::int32_t node, const FileLocation& location) {
    const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
    const auto continues_name = [&](char c) { return is_letter(c) || (c >= '0' && c <= '9'); };
    if (name.empty() || !is_letter(name[0]) || !std::all_of(name.begin(), name.end(), continues_name))
        throw InputError(location, "'" + name +
                                    "' is not a legal name in formulas; a name has letters, digits and _, and does "
                                    "not begin with a digit");
    if (function_named(name))
        throw InputError(location, "'" + name + "' is the name of a function in formulas; choose another name");
    const auto has_name = [&](const auto& entry) { return entry.first == name; };
    if (std::any_of(scope.names.begin(), scope.names.end(), has_name))
        throw InputError(location, "'" + name + "' is already defined in formulas; choose another name");
    if (scope.textbook_nodes.contains(name))
        throw InputError(location, "'" + name + "' is used by a formula above, as the coordinate or momentum of this "
                                    "name; define it before its first use, or choose another name");
    scope.names.emplace_back(name, node);
}

}  // namespace kagero
