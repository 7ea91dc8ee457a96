#include "compiler/asmjit/executable_memory.h"

#include <sys/mman.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>

namespace kagero::compiler {

ExecutableMemory::~ExecutableMemory() {
    if (address_) munmap(address_, size_);
}

unsigned char* ExecutableMemory::allocate(std::size_t size) {
    void* address = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (address == MAP_FAILED)
        throw std::runtime_error(std::string("no memory for machine code: ") + std::strerror(errno));
    address_ = static_cast<unsigned char*>(address);
    size_ = size;
    return address_;
}

void ExecutableMemory::make_executable() {
    if (mprotect(address_, size_, PROT_READ | PROT_EXEC) != 0)
        throw std::runtime_error(std::string("the system does not allow executable memory: ") + std::strerror(errno));
}

}  // namespace kagero::compiler
