/// Primitives that a ray has passed without hitting them, although its chord has hit them.
#pragma once

#include <cstdint>

namespace kagero {

/// For each lane, the primitives that its ray has passed at its last missed hit. The next query ignores them.
template <int W>
struct PassedPrimitives {
    static constexpr int max_count = 8;
    int count[W] = {};
    std::uint32_t surface[max_count][W], primitive[max_count][W];

    /// Adds a primitive in one lane, unless the list of the lane is full.
    void add(int lane, std::uint32_t its_surface, std::uint32_t its_primitive) {
        if (count[lane] == max_count) return;
        surface[count[lane]][lane] = its_surface;
        primitive[count[lane]][lane] = its_primitive;
        ++count[lane];
    }
    /// Copies the list of one lane.
    void copy_lane(int lane, const PassedPrimitives& from) {
        count[lane] = 0;
        for (int i = 0; i < from.count[lane]; ++i) add(lane, from.surface[i][lane], from.primitive[i][lane]);
    }
    /// Returns true if the list of a lane contains the primitive.
    bool contains(int lane, std::uint32_t its_surface, std::uint32_t its_primitive) const {
        for (int i = 0; i < count[lane]; ++i)
            if (surface[i][lane] == its_surface && primitive[i][lane] == its_primitive) return true;
        return false;
    }
};

}  // namespace kagero
