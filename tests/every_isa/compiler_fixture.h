/// Fixture for tests of the compiler module, random values, and their comparison.
#pragma once

#include "compiler/formula_compiler.h"
#include "kernels/formula/compiled_functions.h"
#include "kernels/formula/formula_system.h"
#include "kernels/simd/lane_memory.h"

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <random>
#include <string>
#include <vector>

namespace kagero::test {

/// Returns a new compiler of the module; nullptr if the module cannot be loaded.
inline std::unique_ptr<FunctionCompiler> new_compiler() {
    void* library = dlopen(KAGERO_COMPILER_FILE, RTLD_NOW);
    void* entry = library ? dlsym(library, "kagero_compiler") : nullptr;
    return entry ? reinterpret_cast<CompilerFunction>(entry)()->create() : nullptr;
}

class CompilerTest : public ::testing::Test {
protected:
    void SetUp() override {
        if (std::string(KAGERO_COMPILER_FILE).empty()) GTEST_SKIP() << "the compiler module is not built";
        compiler = new_compiler();
        ASSERT_NE(compiler, nullptr) << dlerror();
    }
    std::unique_ptr<FunctionCompiler> compiler;
};

inline int setting(const char* variable, int default_value) {
    const char* value = std::getenv(variable);
    return value ? std::atoi(value) : default_value;
}

/// Calls visit.operator()<V>() for every value type that is compiled.
template <class Visit>
void visit_types(const Visit& visit) {
    visit.template operator()<Lanes<double, 2>>();
    visit.template operator()<Lanes<float, 2>>();
    visit.template operator()<double>();
    visit.template operator()<float>();
    visit.template operator()<Lanes<double, 1>>();
    visit.template operator()<Lanes<double, 4>>();
    visit.template operator()<Lanes<float, 1>>();
    visit.template operator()<Lanes<float, 4>>();
}

/// Evaluates a code by the interpreter. Packets without an interpreter are evaluated by packets of two registers.
template <class V>
void interpret(const formula::Code& code, const V* in, V* out) {
    if constexpr (formula::is_interpreted<V>) {
        formula::evaluate_interpreted(code, in, out);
    } else {
        using Packet = Lanes<ScalarOf<V>, 2>;
        constexpr int registers = ValueTraits<V>::registers;
        for (int r = 0; r < registers; r += 2) {
            const int second = std::min(r + 1, registers - 1);
            Packet inputs[formula::Code::max_inputs], outputs[formula::Code::max_outputs];
            for (int k = 0; k < code.inputs; ++k) {
                inputs[k].v[0] = in[k].v[r];
                inputs[k].v[1] = in[k].v[second];
            }
            formula::evaluate_interpreted(code, inputs, outputs);
            for (int o = 0; o < code.outputs; ++o) {
                out[o].v[r] = outputs[o].v[0];
                out[o].v[second] = outputs[o].v[second == r ? 0 : 1];
            }
        }
    }
}

/// Returns a random number; one in ten is a special value.
inline double random_number(std::mt19937& random) {
    constexpr double special[] = {0.0, -0.0, 1, -1, INFINITY, -INFINITY, NAN, 1e-310, 1e300, -1e-30, 1e30};
    std::uniform_int_distribution<int> any(0, 99);
    if (const int k = any(random); k < int(std::size(special))) return special[k];
    return std::normal_distribution<double>(0, 2)(random);
}
template <class V>
V random_value(std::mt19937& random) {
    double numbers[lane_count<V>];
    for (double& x : numbers) x = random_number(random);
    return lanes_of<V>(numbers);
}

/// Returns the number of lanes in which the bits of two values differ, unless both are NaN.
template <class V>
int differing_lanes(const V& a, const V& b) {
    int count = 0;
    for (int lane = 0; lane < lane_count<V>; ++lane) {
        const ScalarOf<V> x = get_lane(a, lane), y = get_lane(b, lane);
        if (!(std::isnan(x) && std::isnan(y)) && std::memcmp(&x, &y, sizeof x) != 0) ++count;
    }
    return count;
}

}  // namespace kagero::test
