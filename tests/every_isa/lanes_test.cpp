// Tests of the functions on packets. Each lane of a result is compared with the scalar function of the same name, and
// with the standard library or quadruple precision.
#include "tests/kernels/spaces.h"

#include "kernels/trace/packets.h"

#include <cstring>

namespace kagero::test {
namespace {

template <class V>
class PacketOperations : public ::testing::Test {};
using PacketTypes = ::testing::Types<PacketDouble, PacketFloat>;
struct PacketName {
    template <class V>
    static std::string GetName(int) { return std::is_same_v<ScalarOf<V>, double> ? "double" : "float"; }
};
TYPED_TEST_SUITE(PacketOperations, PacketTypes, PacketName);

/// Returns random numbers of either sign whose magnitudes are between 10^−decades and 10^decades.
template <class V>
V random_packet(Random& random, double decades = 6) {
    V v;
    for (int i = 0; i < lane_count<V>; ++i)
        set_lane(v, i, ScalarOf<V>((random(0, 1) < 0.5 ? -1 : 1) * std::pow(10.0, random(-decades, decades))));
    return v;
}
template <class V>
V absolute(const V& v) {
    V a;
    for (int i = 0; i < lane_count<V>; ++i) set_lane(a, i, std::abs(get_lane(v, i)));
    return a;
}

constexpr int rounds = 200;

/// Expects that every lane of f(packets) is equal to f of the scalars in that lane.
template <class V, class F, class... Packets>
void expect_lanewise(const char* name, const F& f, const Packets&... x) {
    const V packet_result = f(x...);
    for (int i = 0; i < lane_count<V>; ++i) {
        const ScalarOf<V> scalar_result = f(get_lane(x, i)...);
        EXPECT_EQ(get_lane(packet_result, i), scalar_result) << name << " in lane " << i;
    }
}

TYPED_TEST(PacketOperations, ArithmeticMatchesScalars) {
    using V = TypeParam;
    Random random(1);
    for (int round = 0; round < rounds; ++round) {
        const V a = random_packet<V>(random), b = random_packet<V>(random), c = random_packet<V>(random);
        expect_lanewise<V>("+", [](const auto& x, const auto& y) { return x + y; }, a, b);
        expect_lanewise<V>("-", [](const auto& x, const auto& y) { return x - y; }, a, b);
        expect_lanewise<V>("*", [](const auto& x, const auto& y) { return x * y; }, a, b);
        expect_lanewise<V>("/", [](const auto& x, const auto& y) { return x / y; }, a, b);
        expect_lanewise<V>("negation", [](const auto& x) { return -x; }, a);
        expect_lanewise<V>("abs", [](const auto& x) { return abs(x); }, a);
        expect_lanewise<V>("min", [](const auto& x, const auto& y) { return min(x, y); }, a, b);
        expect_lanewise<V>("max", [](const auto& x, const auto& y) { return max(x, y); }, a, b);
        expect_lanewise<V>("sqrt", [](const auto& x) { return sqrt(x); }, absolute(a));
        expect_lanewise<V>("rsqrt", [](const auto& x) { return rsqrt(x); }, absolute(a));
        expect_lanewise<V>("recip", [](const auto& x) { return recip(x); }, a);
        expect_lanewise<V>("fma", [](const auto& x, const auto& y, const auto& z) { return fma(x, y, z); }, a, b, c);
        expect_lanewise<V>("fms", [](const auto& x, const auto& y, const auto& z) { return fms(x, y, z); }, a, b, c);
        expect_lanewise<V>("fnma", [](const auto& x, const auto& y, const auto& z) { return fnma(x, y, z); }, a, b, c);
        expect_lanewise<V>("+=", [](auto x, const auto& y) { return x += y; }, a, b);
        expect_lanewise<V>("-=", [](auto x, const auto& y) { return x -= y; }, a, b);
    }
}

// a·b − round(a·b) is the rounding error of the product if the operation is fused, and 0 if it is not. Packets must
// return the same result as scalars.
TYPED_TEST(PacketOperations, MultiplyAddIsFusedIfAndOnlyIfScalarIsFused) {
    using V = TypeParam;
    Random random(2);
    for (int round = 0; round < rounds; ++round) {
        const V a = random_packet<V>(random, 1), b = random_packet<V>(random, 1), product = a * b;
        expect_lanewise<V>(
            "fms", [](const auto& x, const auto& y, const auto& z) { return fms(x, y, z); }, a, b, product);
        expect_lanewise<V>(
            "fma", [](const auto& x, const auto& y, const auto& z) { return fma(x, y, -z); }, a, b, product);
        expect_lanewise<V>(
            "fnma", [](const auto& x, const auto& y, const auto& z) { return fnma(x, y, z); }, a, b, product);
    }
}

TYPED_TEST(PacketOperations, ReciprocalsAreAccurateToFourUlp) {
    using V = TypeParam;
    using S = ScalarOf<V>;
    Random random(3);
    for (int round = 0; round < 10 * rounds; ++round) {
        const V x = absolute(random_packet<V>(random, std::is_same_v<S, double> ? 100 : 15));
        const V inverse_root = rsqrt(x), inverse = recip(x);
        for (int i = 0; i < lane_count<V>; ++i) {
            const Quad exact = get_lane(x, i), tolerance = 4 * static_cast<Quad>(machine_epsilon<S>);
            EXPECT_LE(static_cast<double>(abs(get_lane(inverse_root, i) * sqrt(exact) - 1)),
                      static_cast<double>(tolerance));
            EXPECT_LE(static_cast<double>(abs(get_lane(inverse, i) * exact - 1)), static_cast<double>(tolerance));
        }
    }
}

// total_recip and total_rsqrt return the limits for 0 and ∞. These arguments occur where an exponential overflows or a
// coordinate is 0. For all other arguments the results are those of recip and rsqrt.
TYPED_TEST(PacketOperations, TotalReciprocalsAcceptZeroAndInfinity) {
    using V = TypeParam;
    using S = ScalarOf<V>;
    const S infinity = std::numeric_limits<S>::infinity();
    EXPECT_EQ(get_lane(total_recip(V(infinity)), 0), 0);
    EXPECT_EQ(get_lane(total_recip(V(-infinity)), 0), 0);
    EXPECT_EQ(get_lane(total_recip(V(S(0))), 0), infinity);
    EXPECT_EQ(get_lane(total_recip(V(S(-0.0))), 0), -infinity);
    EXPECT_EQ(get_lane(total_rsqrt(V(infinity)), 0), 0);
    EXPECT_EQ(get_lane(total_rsqrt(V(S(0))), 0), infinity);
    EXPECT_TRUE(std::isnan(get_lane(total_rsqrt(V(S(-1))), 0)));
    EXPECT_TRUE(std::isnan(get_lane(total_recip(V(std::numeric_limits<S>::quiet_NaN())), 0)));
    Random random(4);
    for (int round = 0; round < rounds; ++round) {
        const V x = absolute(random_packet<V>(random, std::is_same_v<S, double> ? 100 : 15));
        for (int i = 0; i < lane_count<V>; ++i) {
            EXPECT_EQ(get_lane(total_recip(x), i), get_lane(recip(x), i));
            EXPECT_EQ(get_lane(total_rsqrt(x), i), get_lane(rsqrt(x), i));
        }
    }
}

// Packets and the standard library round these functions differently. The tolerance is four ulp of 1 + |result|, so
// that it is absolute near the zeros of a function.
TYPED_TEST(PacketOperations, TranscendentalFunctionsAreAccurateToFourUlp) {
    using V = TypeParam;
    using S = ScalarOf<V>;
    Random random(4);
    const auto check = [](const char* name, const V& packet_result, const V& x, const auto& exact) {
        for (int i = 0; i < lane_count<V>; ++i) {
            const double y = exact(static_cast<double>(get_lane(x, i)));
            EXPECT_NEAR(static_cast<double>(get_lane(packet_result, i)), y,
                        4 * static_cast<double>(machine_epsilon<S>) * (1 + std::abs(y)))
                << name << " of " << get_lane(x, i);
        }
    };
    for (int round = 0; round < rounds; ++round) {
        V x;
        for (int i = 0; i < lane_count<V>; ++i) set_lane(x, i, S(random(-1.4, 1.4)));
        check("exp", exp(x), x, [](double a) { return std::exp(a); });
        check("log", log(exp(x)), exp(x), [](double a) { return std::log(a); });
        check("sin", sin(x), x, [](double a) { return std::sin(a); });
        check("cos", cos(x), x, [](double a) { return std::cos(a); });
        check("tan", tan(x), x, [](double a) { return std::tan(a); });
        check("tanh", tanh(x), x, [](double a) { return std::tanh(a); });
        for (const double abscissa : {0.7, -0.7, 0.0})
            check("atan2", atan2(x, V(S(abscissa))), x,
                  [abscissa](double a) { return std::atan2(a, static_cast<double>(S(abscissa))); });
    }
    for (const double abscissa : {0.7, -0.7, 0.0, -0.0}) {
        const V angle = atan2(V(S(0)), V(S(abscissa)));
        for (int i = 0; i < lane_count<V>; ++i)
            EXPECT_NEAR(get_lane(angle, i), std::atan2(0.0, abscissa), 1e-6) << abscissa;
    }
}

// The arguments are up to 1000, except for one lane with 1e15 or ∞, which the argument reduction cannot handle. The
// results for finite arguments must agree with the standard library to two ulp of 1. Each lane must be equal to the
// scalar function bit for bit, so that it does not depend on the other lanes.
TYPED_TEST(PacketOperations, TrigonometricFunctionsOfLargeArgumentsAreAccurate) {
    using V = TypeParam;
    using S = ScalarOf<V>;
    Random random(8);
    for (int round = 0; round < 10 * rounds; ++round) {
        V x = random_packet<V>(random, 3);
        set_lane(x, random.below(lane_count<V>), round % 2 ? S(1e15) : std::numeric_limits<S>::infinity());
        const V s = sin(x), c = cos(x), t = tan(x);
        for (int i = 0; i < lane_count<V>; ++i) {
            const S a = get_lane(x, i);
            if (!std::isfinite(a)) {
                EXPECT_TRUE(std::isnan(get_lane(s, i)) && std::isnan(get_lane(c, i)));
                continue;
            }
            EXPECT_NEAR(get_lane(s, i), std::sin(static_cast<double>(a)), 2 * machine_epsilon<S>) << a;
            EXPECT_NEAR(get_lane(c, i), std::cos(static_cast<double>(a)), 2 * machine_epsilon<S>) << a;
            EXPECT_EQ(get_lane(s, i), sin(a));
            EXPECT_EQ(get_lane(c, i), cos(a));
            EXPECT_EQ(get_lane(t, i), tan(a));
        }
    }
}

TYPED_TEST(PacketOperations, ComparisonsMasksAndSelectMatchScalars) {
    using V = TypeParam;
    using S = ScalarOf<V>;
    Random random(5);
    for (int round = 0; round < rounds; ++round) {
        V a, b;
        for (int i = 0; i < lane_count<V>; ++i) {
            set_lane(a, i, S(random.below(3)));
            set_lane(b, i, S(random.below(3)));
        }
        const std::uint64_t less = to_bits(a < b), at_most = to_bits(a <= b), greater = to_bits(a > b),
                            at_least = to_bits(a >= b);
        const std::uint64_t both = to_bits((a <= b) & (a >= b)), either = to_bits((a < b) | (a > b)),
                            neither = to_bits(!(a < b));
        const V selected = select(a < b, a, b);
        for (int i = 0; i < lane_count<V>; ++i) {
            const S x = get_lane(a, i), y = get_lane(b, i);
            const auto bit = [i](std::uint64_t bits) { return ((bits >> i) & 1) != 0; };
            EXPECT_EQ(bit(less), x < y);
            EXPECT_EQ(bit(at_most), x <= y);
            EXPECT_EQ(bit(greater), x > y);
            EXPECT_EQ(bit(at_least), x >= y);
            EXPECT_EQ(bit(both), x == y);
            EXPECT_EQ(bit(either), x != y);
            EXPECT_EQ(bit(neither), !(x < y));
            EXPECT_EQ(get_lane(selected, i), x < y ? x : y);
        }
        EXPECT_EQ(any(a < b), less != 0);
    }
}

TYPED_TEST(PacketOperations, BitsToMaskToBitsIsTheIdentity) {
    using V = TypeParam;
    constexpr int lanes = lane_count<V>;
    static_assert(lanes < 64);
    constexpr std::uint64_t all = (std::uint64_t(1) << lanes) - 1;
    std::mt19937_64 engine(6);
    for (int round = 0; round < rounds; ++round) {
        const std::uint64_t bits = engine() & all;
        EXPECT_EQ(to_bits(from_bits<V>(bits)), bits);
        EXPECT_EQ(to_bits(!from_bits<V>(bits)) & all, ~bits & all);
    }
    EXPECT_EQ(to_bits(from_bits<V>(0)), 0u);
    EXPECT_EQ(to_bits(from_bits<V>(all)), all);
}

TYPED_TEST(PacketOperations, IsFiniteRejectsInfinityAndNan) {
    using V = TypeParam;
    using S = ScalarOf<V>;
    using Limits = std::numeric_limits<S>;
    const S values[] = {0,
                        1,
                        -1,
                        Limits::max(),
                        -Limits::max(),
                        Limits::denorm_min(),
                        Limits::infinity(),
                        -Limits::infinity(),
                        Limits::quiet_NaN()};
    for (const S value : values) {
        for (int lane = 0; lane < lane_count<V>; ++lane) {
            V v(S(2));
            set_lane(v, lane, value);
            const std::uint64_t expected = std::isfinite(value) ? 0 : std::uint64_t(1) << lane;
            EXPECT_EQ(to_bits(!is_finite(v)), expected) << value;
            EXPECT_EQ(is_finite(value), std::isfinite(value));
        }
    }
}

// A comparison with NaN is false. min and max of packets return NaN for the same operands as min and max of scalars.
TYPED_TEST(PacketOperations, NanIsTreatedAsInScalars) {
    using V = TypeParam;
    using S = ScalarOf<V>;
    const S nan = std::numeric_limits<S>::quiet_NaN();
    const V all_nan(nan), ones(S(1));
    EXPECT_EQ(to_bits(all_nan < ones) | to_bits(all_nan <= ones) | to_bits(all_nan > ones) | to_bits(all_nan >= ones),
              0u);
    for (const auto& [a, b] : {std::pair(nan, S(1)), std::pair(S(1), nan)}) {
        const S packet_min = get_lane(min(V(a), V(b)), 0), packet_max = get_lane(max(V(a), V(b)), 0);
        EXPECT_EQ(std::isnan(packet_min), std::isnan(min(a, b)));
        EXPECT_EQ(std::isnan(packet_max), std::isnan(max(a, b)));
    }
}

TYPED_TEST(PacketOperations, LanesCanBeReadAndWritten) {
    using V = TypeParam;
    using S = ScalarOf<V>;
    V v(S(7));
    for (int i = 0; i < lane_count<V>; ++i) set_lane(v, i, S(i));
    for (int i = 0; i < lane_count<V>; ++i) EXPECT_EQ(get_lane(v, i), S(i));
    EXPECT_EQ(sizeof(V), sizeof(S) * lane_count<V>);
}

}  // namespace
}  // namespace kagero::test
