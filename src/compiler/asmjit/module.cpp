// The compiler module. The files of this folder are the only ones that use AsmJit.
#include "compiler/asmjit/executable_memory.h"
#include "compiler/asmjit/function_writer.h"
#include "compiler/formula_compiler.h"

#include <cstdio>
#include <stdexcept>

namespace kagero::compiler {
namespace {

/// Turns errors of AsmJit, which would be errors of this module, into exceptions.
class ThrowErrors final : public asmjit::ErrorHandler {
public:
    void handleError(asmjit::Error, const char* message, asmjit::BaseEmitter*) override {
        throw std::runtime_error(std::string("the machine code cannot be generated: ") + message);
    }
};

class AsmjitCompiler final : public FunctionCompiler {
public:
    AsmjitCompiler() {
        code_.init(asmjit::Environment::host());
        code_.setErrorHandler(&throw_errors_);
        code_.attach(&assembler_);
    }
    void add(const FunctionDescription& function) override {
        assembler_.align(asmjit::AlignMode::kCode, 64);
        offsets_.push_back(assembler_.offset());
        write_function(assembler_, function);
    }
    std::vector<CompiledFunction> finish() override {
        check(code_.flatten());
        check(code_.resolveUnresolvedLinks());
        const std::size_t size = code_.codeSize();
        unsigned char* address = memory_.allocate(size);
        check(code_.relocateToBase(reinterpret_cast<std::uintptr_t>(address)));
        check(code_.copyFlattenedData(address, size));
        memory_.make_executable();
        std::vector<CompiledFunction> functions;
        for (const std::size_t offset : offsets_)
            functions.push_back(reinterpret_cast<CompiledFunction>(address + offset));
        code_.reset(asmjit::ResetPolicy::kHard);
        return functions;
    }

private:
    static void check(asmjit::Error error) {
        if (error)
            throw std::runtime_error(std::string("the machine code cannot be moved to memory: ") +
                                     asmjit::DebugUtils::errorAsString(error));
    }

    ThrowErrors throw_errors_;
    asmjit::CodeHolder code_;
    asmjit::x86::Assembler assembler_;
    std::vector<std::size_t> offsets_;
    ExecutableMemory memory_;
};

constexpr CompilerModule functions{code_generation_abi, []() -> std::unique_ptr<FunctionCompiler> {
                                       return std::make_unique<AsmjitCompiler>();
                                   }};

}  // namespace
}  // namespace kagero::compiler

// Debian's libasmjit.a refers to `stderr` by an address relative to the code, which is impossible in a shared library.
// The linker replaces it by this variable (--wrap).
extern "C" {
__attribute__((visibility("hidden"))) FILE* __wrap_stderr = stderr;
}

extern "C" __attribute__((visibility("default"))) const kagero::CompilerModule* kagero_compiler() {
    return &kagero::compiler::functions;
}
