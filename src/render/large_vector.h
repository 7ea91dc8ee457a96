/// Vectors with one element per ray of a long list.
#pragma once

#include "render/threads.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace kagero {

/// Returns a vector of n elements. Where the system permits, the memory of a long vector consists of huge pages, and
/// several threads wait for them, because the system takes long to provide and to clear pages.
template <class T>
std::vector<T> large_vector(std::size_t n, unsigned threads) {
    constexpr std::uintptr_t huge_page = 1 << 21;  // bytes
    std::vector<T> elements;
    elements.reserve(n);
    const auto begin = reinterpret_cast<std::uintptr_t>(elements.data()), end = begin + n * sizeof(T);
    const std::uintptr_t first = (begin + huge_page - 1) / huge_page, last = end / huge_page;
    // The pages are small or come later if such advice is refused.
    const auto advise = [](std::uintptr_t from, std::uintptr_t to, int advice) {
        if (from < to) ::madvise(reinterpret_cast<void*>(from * huge_page), (to - from) * huge_page, advice);
    };
    advise(first, last, MADV_HUGEPAGE);
    if (first + 1 < last)
        run_on_threads(threads, [&](unsigned thread) {
            const auto bound = [&](std::uintptr_t part) { return first + (last - first) * part / threads; };
            advise(bound(thread), bound(thread + 1), MADV_POPULATE_WRITE);
        });
    elements.resize(n);
    return elements;
}

}  // namespace kagero
