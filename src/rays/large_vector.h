/// Vectors with one element per ray of a long list.
#pragma once

#include <sys/mman.h>

#include <cstdint>
#include <vector>

namespace kagero {

/// Returns a vector of n elements. Where the system permits, the memory of a long vector consists of huge pages,
/// because the system takes long to provide many small pages.
template <class T>
std::vector<T> large_vector(std::size_t n) {
    constexpr std::uintptr_t huge_page = 1 << 21;  // bytes
    std::vector<T> elements;
    elements.reserve(n);
    const auto begin = reinterpret_cast<std::uintptr_t>(elements.data()), end = begin + n * sizeof(T);
    const std::uintptr_t first = (begin + huge_page - 1) / huge_page * huge_page, last = end / huge_page * huge_page;
    // If this advice is refused, the pages are small.
    if (first < last) ::madvise(reinterpret_cast<void*>(first), last - first, MADV_HUGEPAGE);
    elements.resize(n);
    return elements;
}

}  // namespace kagero
