/// Memory for the bytes of an AppendFile that bypasses the cache.
#pragma once

#include "parts/append_file.h"
#include "parts/record.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <new>
#include <string>

namespace kagero {

/// Records in memory whose address and size are multiples of AppendFile::block. A record `padding` fills the rest.
class WriteBlock {
public:
    /// Reserves memory for records of `size` bytes in all, and their padding.
    explicit WriteBlock(std::size_t size)
        : capacity_(aligned(size + least_padding)), memory_(static_cast<char*>(::operator new(capacity_, alignment))) {}

    bool empty() const { return size_ == 0; }
    std::size_t capacity() const { return capacity_; }
    /// Returns true if there is memory for a further record of this size, in bytes.
    bool fits(std::size_t size) const { return aligned(size_ + size + least_padding) <= capacity_; }
    void append(std::string_view record) {
        std::memcpy(memory_.get() + size_, record.data(), record.size());
        size_ += record.size();
    }
    /// Appends the record `padding` if it is needed. Returns all bytes.
    std::string_view padded() {
        append(padding_after(size_));
        return {memory_.get(), size_};
    }
    void clear() { size_ = 0; }

    /// Returns the record `padding` after which `size` preceding bytes fill whole blocks; no bytes if they do already.
    static std::string padding_after(std::uint64_t size) {
        if (size % AppendFile::block == 0) return {};
        return padding_record(aligned(size + least_padding) - size);
    }

private:
    static constexpr std::align_val_t alignment{AppendFile::block};
    struct Delete {
        void operator()(char* memory) const { ::operator delete(memory, alignment); }
    };
    static std::size_t aligned(std::size_t size) {
        return (size + AppendFile::block - 1) / AppendFile::block * AppendFile::block;
    }

    std::size_t capacity_, size_ = 0;
    std::unique_ptr<char, Delete> memory_;
};

}  // namespace kagero
