#include "library/ray_arrays.h"

#include "rays/large_vector.h"
#include "render/threads.h"

#include <algorithm>
#include <atomic>

namespace kagero {

std::vector<RayStart> start_arrays(const Plan& plan, const RayArrays& rays, std::optional<ObserverKind> observer) {
    constexpr std::size_t chunk = 4096;  // rays
    const std::size_t chunks = (rays.count + chunk - 1) / chunk;
    std::vector<RayStart> starts = large_vector<RayStart>(rays.count);
    std::atomic<std::size_t> next = 0;
    run_on_threads(static_cast<unsigned>(std::clamp<std::size_t>(chunks, 1, plan.run.threads)), [&](unsigned) {
        for (std::size_t i = next++; i < chunks; i = next++) {
            const std::size_t first = i * chunk, last = std::min(first + chunk, rays.count);
            write_starts(plan, rays, observer, first, last, starts.data() + first);
        }
    });
    return starts;
}

}  // namespace kagero
