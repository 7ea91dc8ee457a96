/// Vectors with one element per ray of a long list, or per pixel of a picture.
#pragma once

#include <sys/mman.h>

#include <algorithm>
#include <cstdint>
#include <system_error>
#include <thread>
#include <vector>

namespace kagero {

/// Returns a vector of n elements with this value. Where the system permits, the memory of a long vector consists of
/// huge pages, because the system takes long to provide small ones. If `threads` is greater than 0, so many threads
/// wait until the system has provided and cleared the pages.
template <class T>
std::vector<T> large_vector(std::size_t n, unsigned threads, const T& value = T()) {
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
    std::vector<std::jthread> helpers;
    try {
        for (unsigned thread = 0; thread < threads && first + 1 < last; ++thread)
            helpers.emplace_back(advise, first + (last - first) * thread / threads,
                                 first + (last - first) * (thread + 1) / threads, MADV_POPULATE_WRITE);
    } catch (const std::system_error&) {}  // no further thread: these pages come later
    helpers.clear();
    elements.resize(n, value);
    return elements;
}

}  // namespace kagero
