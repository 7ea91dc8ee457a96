/// Memory for machine code.
#pragma once

#include <cstddef>

namespace kagero::compiler {

/// Memory that is first writable and then executable, but never both. The destructor frees it.
class ExecutableMemory {
public:
    ExecutableMemory() = default;
    ExecutableMemory(const ExecutableMemory&) = delete;
    ExecutableMemory& operator=(const ExecutableMemory&) = delete;
    ~ExecutableMemory();

    /// Allocates writable memory and returns its address. Throws std::runtime_error if the system refuses.
    unsigned char* allocate(std::size_t size);
    /// Makes the memory executable; it can no longer be written. Throws std::runtime_error if the system refuses.
    void make_executable();

private:
    unsigned char* address_ = nullptr;
    std::size_t size_ = 0;
};

}  // namespace kagero::compiler
