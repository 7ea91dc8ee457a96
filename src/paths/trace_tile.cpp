#include "paths/trace_tile.h"

#include "kernels/assertion.h"

#include <pmmintrin.h>

namespace kagero {
namespace {

/// Makes this thread treat denormal numbers as zero while the object exists. Arithmetic with denormal numbers is a
/// hundred times slower.
class FlushDenormals {
public:
    FlushDenormals() : saved_mode_(_mm_getcsr()) {
        _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
        _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
    }
    ~FlushDenormals() { _mm_setcsr(saved_mode_); }
    FlushDenormals(const FlushDenormals&) = delete;
    FlushDenormals& operator=(const FlushDenormals&) = delete;

private:
    unsigned saved_mode_;
};

}  // namespace

std::size_t ray_count_of(const Tile& tile, const RayList& list) {
    return list.starts.empty() ? std::size_t(tile.x1 - tile.x0) * (tile.y1 - tile.y0) : list.starts.size();
}

void trace_tile(const KernelInfo& kernel, Job job, const Tile& tile, const RayList& list, std::vector<RayEnd>& ends,
                Counters& counters) {
    const FlushDenormals flush;
    KAGERO_ASSERT(list.starts.empty() ? (job.camera || job.rays)
                                      : (list.frequencies.empty() || list.frequencies.size() == list.starts.size()));
    ends.resize(ray_count_of(tile, list));
    if (list.starts.empty()) return kernel.trace(&job, &tile, ends.data(), &counters);
    job.camera = nullptr;
    job.rays = list.starts.data();
    const Tile whole_list{0, 0, static_cast<std::uint32_t>(list.starts.size()), 1};
    kernel.trace(&job, &whole_list, ends.data(), &counters);
}

}  // namespace kagero
