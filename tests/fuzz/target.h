/// What a fuzz target defines. The entry point is libFuzzer's, so that with clang a target can be linked with
/// -fsanitize=fuzzer instead of with driver.cpp.
#pragma once

#include <cstddef>
#include <cstdint>

/// 0 where the input was taken, −1 where it was refused as it should be. Everything else – another exception, an
/// endless loop, a sanitizer's report – ends the process.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

/// Words of the target's language, in one string between spaces; put into inputs here and there.
extern const char* const fuzz_words;
