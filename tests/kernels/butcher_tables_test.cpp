// The tables of explicit Runge–Kutta methods satisfy the order conditions of every rooted tree up to their order, and
// not all of the next: Σ_i b_i Φ_i(t) = 1/γ(t) (Hairer, Nørsett & Wanner 1993, §II.2).
#include "kernels/methods/methods.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace kagero::test {
namespace {

constexpr int highest_order = 10;

/// The trees at the root of one, by number, the greatest first; how many nodes it has, and γ.
struct Tree {
    std::vector<int> branches;
    int order;
    double density;
};

/// Adds the trees that `branches`, and more with `left` nodes, none of a greater number than `greatest`, make.
void add_trees(std::vector<Tree>& trees, std::vector<int>& branches, int order, int left, int greatest) {
    if (left == 0) {
        double density = order;
        for (const int branch : branches) density *= trees[branch].density;
        trees.push_back({branches, order, density});
        return;
    }
    for (int branch = greatest; branch >= 0; --branch) {
        if (trees[branch].order > left) continue;
        branches.push_back(branch);
        add_trees(trees, branches, order, left - trees[branch].order, branch);
        branches.pop_back();
    }
}

/// Every tree of at most `highest_order` nodes, in order of their number.
const std::vector<Tree>& all_trees() {
    static const std::vector<Tree> trees = [] {
        std::vector<Tree> found{{{}, 1, 1}};
        std::vector<int> branches;
        for (int order = 2; order <= highest_order; ++order)
            add_trees(found, branches, order, order - 1, static_cast<int>(found.size()) - 1);
        return found;
    }();
    return trees;
}

TEST(ButcherTables, ThereAreAsManyTreesAsCayleyCounted) {
    int count[highest_order + 1] = {};
    for (const Tree& tree : all_trees()) ++count[tree.order];
    constexpr int known[highest_order + 1] = {0, 1, 1, 2, 4, 9, 20, 48, 115, 286, 719};
    for (int order = 1; order <= highest_order; ++order) EXPECT_EQ(count[order], known[order]);
}

/// How far off the worst condition of each order is.
std::vector<double> residuals(const ButcherTable& table, const double* weights) {
    std::vector<std::vector<double>> phi;  // of every tree at every stage
    std::vector<double> worst(highest_order + 1);
    for (const Tree& tree : all_trees()) {
        std::vector<double>& here = phi.emplace_back(table.stages, 1.0);
        for (const int branch : tree.branches)
            for (int i = 0; i < table.stages; ++i) {
                double sum = 0;
                for (int j = 0; j < i; ++j) sum += table.a[i][j] * phi[branch][j];
                here[i] *= sum;
            }
        double sum = 0;
        for (int i = 0; i < table.stages; ++i) sum += weights[i] * here[i];
        worst[tree.order] = std::max(worst[tree.order], std::abs(sum - 1 / tree.density));
    }
    return worst;
}

/// Of a condition, what roundings of the coefficients leave.
constexpr double rounding = 2e-14;

void expect_order(const ButcherTable& table, const double* weights, int order, const char* which) {
    const std::vector<double> worst = residuals(table, weights);
    for (int n = 1; n <= order; ++n) EXPECT_LE(worst[n], rounding) << which << ", order " << n;
    EXPECT_GE(worst[order + 1], 1e-6) << which << " is of a higher order than stated";
}

TEST(ButcherTables, SatisfyTheOrderConditionsOfTheirOrderAndNoMore) {
    int tables = 0;
    for (const Method& method : methods) {
        const ButcherTable* table = method.coefficients.table;
        if (!table) continue;
        ++tables;
        expect_order(*table, table->b, static_cast<int>(method.info.order), method.info.name);
        ASSERT_EQ(table->estimate_order > 0, method.info.adaptive) << method.info.name;
        if (!method.info.adaptive) continue;
        double embedded[max_rk_stages];
        for (int i = 0; i < max_rk_stages; ++i) embedded[i] = table->b[i] - table->error[i];
        expect_order(*table, embedded, table->estimate_order, method.info.name);
    }
    EXPECT_GE(tables, 7);
}

}  // namespace
}  // namespace kagero::test
