#include "render/threads.h"

#include <exception>
#include <thread>
#include <vector>

namespace kagero {

void on_threads(unsigned threads, const std::function<void(unsigned)>& task) {
    std::vector<std::exception_ptr> failures(threads);
    const auto guarded = [&](unsigned i) {
        try {
            task(i);
        } catch (...) {
            failures[i] = std::current_exception();
        }
    };
    {
        std::vector<std::jthread> team;
        for (unsigned i = 1; i < threads; ++i) team.emplace_back(guarded, i);
        guarded(0);
    }
    for (const std::exception_ptr& failure : failures)
        if (failure) std::rethrow_exception(failure);
}

}  // namespace kagero
