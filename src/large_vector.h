/// Vectors with one element per ray of a long list, or per pixel of a picture.
#pragma once

#include <sys/mman.h>

#include <algorithm>
#include <cstdint>
#include <system_error>
#include <thread>
#include <vector>

namespace kagero {

/// Returns a vector of n elements with this value. The memory of a long vector is requested from the system at once,
/// and consists of huge pages where the system permits them, because it takes long to provide small pages one by one.
/// `threads` threads share this work; with 0, the calling thread does it.
template <class T>
std::vector<T> large_vector(std::size_t n, unsigned threads, const T& value = T()) {
    constexpr std::uintptr_t page = 1 << 12, huge_page = 1 << 21;  // bytes
    std::vector<T> elements;
    elements.reserve(n);
    const auto begin = reinterpret_cast<std::uintptr_t>(elements.data()), end = begin + n * sizeof(T);
    const std::uintptr_t first = (begin + page - 1) / page, count = end / page - std::min(first, end / page);
    // Without such advice, the pages are small or come later.
    const auto advise = [first](std::uintptr_t from, std::uintptr_t to, int advice) {
        ::madvise(reinterpret_cast<void*>((first + from) * page), (to - from) * page, advice);
    };
    if (count >= huge_page / page) {
        advise(0, count, MADV_HUGEPAGE);
        std::vector<std::jthread> helpers;
        try {
            for (unsigned thread = 0; thread < threads; ++thread)
                helpers.emplace_back(advise, count * thread / threads, count * (thread + 1) / threads,
                                     MADV_POPULATE_WRITE);
        } catch (const std::system_error&) {}  // no further thread: these pages come later
        if (threads == 0) advise(0, count, MADV_POPULATE_WRITE);
    }
    elements.resize(n, value);
    return elements;
}

}  // namespace kagero
