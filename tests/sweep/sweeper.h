/// Sweeps of a scene text, and their comparison with one trace per set.
#pragma once

#include "scene/value.h"
#include "sweep/sweep.h"
#include "tests/support/plan_fixture.h"
#include "tuning/resolve.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kagero::test {

/// A scene text, from which plans for lists of rays are made.
struct Sweeper {
    std::string text;
    Options options;

    PlanWithOverrides plan_with() const {
        return [this](const std::vector<std::string>& overrides) {
            const Overrides keys(overrides.begin(), overrides.end());
            return resolve(load_scene_text(text, "sweep.toml", keys, catalogue(options.isa), SceneUse::single_rays),
                           options, Purpose::ray_list);
        };
    }
    SweepResult sweep(const std::vector<SweptKey>& keys, const std::vector<RayInput>& rays) const {
        return kagero::sweep(plan_with(), keys, rays, options.observer);
    }
    /// Returns the ends of the rays of one set, traced by a plan of that set.
    std::vector<RayEnd> trace_set(const std::vector<SweptKey>& keys, std::size_t set,
                                  const std::vector<RayInput>& rays) const {
        std::vector<std::string> overrides;
        for (const SweptKey& key : keys) overrides.push_back(key.key + "=" + to_toml(key.values[set]));
        const Plan plan = plan_with()(overrides);
        std::vector<RayEnd> ends;
        trace(plan, start_rays(plan, rays, options.observer), ends);
        return ends;
    }
};

/// Returns options with which all columns are computed; the time only if `time` is true.
inline Options all_columns(bool time) {
    Options options;
    options.energy_error = options.parameter = options.action = true;
    options.time = time;
    options.threads = 2;
    return options;
}

inline double distance(const double (&a)[3], const double (&b)[3]) {
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// Expects the ends of the sweep to be those of one trace per set. `tolerance` is relative to lengths of about 10.
inline void expect_same_as_separate(const Sweeper& sweeper, const std::vector<SweptKey>& keys,
                                    const std::vector<RayInput>& rays, double tolerance, const SweepResult& result) {
    ASSERT_EQ(result.ends.size(), rays.size() * keys.front().values.size());
    for (std::size_t set = 0; set < keys.front().values.size(); ++set) {
        const std::vector<RayEnd> expected = sweeper.trace_set(keys, set, rays);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const RayEnd &a = result.ends[set * rays.size() + i], &b = expected[i];
            SCOPED_TRACE(keys.front().key + " = " + to_toml(keys.front().values[set]) + ", ray " + std::to_string(i));
            ASSERT_EQ(int(a.status), int(b.status));
            EXPECT_EQ(int(a.failure), int(b.failure));
            EXPECT_EQ(a.steps == 0, b.steps == 0);
            if (a.status == Status::hit) {
                EXPECT_EQ(a.surface, b.surface);
            }
            if (a.status != Status::hit && a.status != Status::escaped) continue;
            const double size = 10 * tolerance;
            EXPECT_LE(distance(a.q, b.q), size);
            EXPECT_LE(distance(a.v, b.v), tolerance);
            EXPECT_LE(distance(a.p, b.p), tolerance * (1 + std::hypot(b.p[0], b.p[1], b.p[2])));
            EXPECT_NEAR(a.pt, b.pt, tolerance);
            EXPECT_NEAR(a.parameter, b.parameter, size * (1 + std::abs(b.parameter)));
            EXPECT_NEAR(a.action, b.action, size * (1 + std::abs(b.action)));
            EXPECT_NEAR(a.time, b.time, size * (1 + std::abs(b.time)));
            EXPECT_LT(a.energy_error, 1e-6);
        }
    }
}

/// Returns rays that pass the origin at several distances, and one whose direction is zero.
inline std::vector<RayInput> passing_rays() {
    std::vector<RayInput> rays;
    for (int i = 0; i < 6; ++i)
        rays.push_back({{-7, 0.35 + 0.9 * i, 0.6 + 0.1 * i}, {1, 0.02 * i, 0.03 - 0.04 * (i % 3)}});
    rays.push_back({{1, 2, 3}, {0, 0, 0}});
    return rays;
}

}  // namespace kagero::test
