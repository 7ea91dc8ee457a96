/// Declarations of the functions and data that a fuzz target defines. The entry point is libFuzzer's, so that with
/// clang a target can be linked with -fsanitize=fuzzer instead of with driver.cpp.
#pragma once

#include <cstddef>
#include <cstdint>

/// Returns 0 if the input was accepted, and −1 if it was refused by an InputError. Any other exception, an endless loop
/// and a report of a sanitizer are failures.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

/// Words of the language of the target, separated by spaces. The driver inserts them into inputs.
extern const char* const fuzz_words;
