#include "spaces/velocity.h"

#include "formula/nodes.h"
#include "kernels/operation.h"
#include "scene/value.h"

namespace kagero {
namespace {

/// Returns the node of a component.
const FormulaNode& root_of(const VelocityDescription& velocity, std::size_t component) {
    return velocity.scope.nodes[static_cast<std::size_t>(velocity.nodes[component])];
}

}  // namespace

Double3 velocity_at(const VelocityDescription& velocity, const double (&q)[3]) {
    const double unit = velocity.length_unit;
    const FormulaPoint point{unit * q[0], unit * q[1], unit * q[2]};
    Double3 v;
    for (std::size_t i = 0; i < 3; ++i) {
        const FormulaNode& root = root_of(velocity, i);
        v[i] = root.op == Op::constant ? root.value : evaluate(velocity.scope, velocity.nodes[i], point);
    }
    return v;
}

std::string text_of(const VelocityDescription& velocity, const double (&q)[3]) {
    std::string text;
    for (const std::string& component : velocity.components) append_to_list(text, component);
    bool is_constant = true;
    for (std::size_t i = 0; i < 3; ++i) is_constant = is_constant && root_of(velocity, i).op == Op::constant;
    return '[' + text + ']' + (is_constant ? "" : " = " + to_toml(velocity_at(velocity, q)));
}

}  // namespace kagero
