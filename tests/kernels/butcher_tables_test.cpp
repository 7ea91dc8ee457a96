// The Butcher tables of explicit Runge–Kutta methods satisfy the order conditions of all rooted trees up to their
// order, and violate at least one condition of the next order. The condition of a tree t is Σ_i b_i Φ_i(t) = 1/γ(t)
// (Hairer, Nørsett & Wanner 1993, §II.2).
#include "kernels/methods/methods.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace kagero::test {
namespace {

constexpr int highest_order = 10;

/// A rooted tree.
struct Tree {
    std::vector<int> branches;  ///< Indices of the subtrees at the root, in descending order.
    int order;                  ///< Number of nodes.
    double density;             ///< γ(t): the product of the orders of the tree and of all its subtrees.
};

/// Appends all trees with `order` nodes whose branches are the given ones and further ones. The further branches have
/// `remaining` nodes in total, and indices of at most `greatest_index`.
void add_trees(std::vector<Tree>& trees, std::vector<int>& branches, int order, int remaining, int greatest_index) {
    if (remaining == 0) {
        double density = order;
        for (const int branch : branches) density *= trees[branch].density;
        trees.push_back({branches, order, density});
        return;
    }
    for (int branch = greatest_index; branch >= 0; --branch) {
        if (trees[branch].order > remaining) continue;
        branches.push_back(branch);
        add_trees(trees, branches, order, remaining - trees[branch].order, branch);
        branches.pop_back();
    }
}

/// Returns all trees of at most `highest_order` nodes, sorted by the number of nodes.
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

// The expected numbers are those of unlabelled rooted trees with 1 to 10 nodes, which Cayley was the first to count.
TEST(ButcherTables, NumberOfRootedTreesMatchesCayley) {
    int count[highest_order + 1] = {};
    for (const Tree& tree : all_trees()) ++count[tree.order];
    constexpr int expected[highest_order + 1] = {0, 1, 1, 2, 4, 9, 20, 48, 115, 286, 719};
    for (int order = 1; order <= highest_order; ++order) EXPECT_EQ(count[order], expected[order]);
}

/// Returns, for each order, the greatest residual of the conditions of this order.
std::vector<double> residuals(const ButcherTable& table, const double* weights) {
    std::vector<std::vector<double>> phi;  // Φ_i(t) for every tree t and stage i
    std::vector<double> worst(highest_order + 1);
    for (const Tree& tree : all_trees()) {
        std::vector<double>& stage_phi = phi.emplace_back(table.stages, 1.0);
        for (const int branch : tree.branches)
            for (int i = 0; i < table.stages; ++i) {
                double sum = 0;
                for (int j = 0; j < i; ++j) sum += table.a[i][j] * phi[branch][j];
                stage_phi[i] *= sum;
            }
        double sum = 0;
        for (int i = 0; i < table.stages; ++i) sum += weights[i] * stage_phi[i];
        worst[tree.order] = std::max(worst[tree.order], std::abs(sum - 1 / tree.density));
    }
    return worst;
}

/// Bound on the residual of a condition that is caused by the rounding of the coefficients.
constexpr double rounding_residual = 2e-14;

void expect_order(const ButcherTable& table, const double* weights, int order, const char* method) {
    const std::vector<double> worst = residuals(table, weights);
    for (int n = 1; n <= order; ++n) EXPECT_LE(worst[n], rounding_residual) << method << ", order " << n;
    EXPECT_GE(worst[order + 1], 1e-6) << method << " has a higher order than the table states.";
}

// Tests the weights of each method and, if the method is adaptive, the weights of the embedded method.
TEST(ButcherTables, SatisfyOrderConditionsExactlyUpToTheStatedOrder) {
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
