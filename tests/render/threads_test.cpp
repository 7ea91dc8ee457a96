// Tests of run_on_threads, which runs each task in a thread of its own.
#include "render/threads.h"

#include <gtest/gtest.h>

#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include <sched.h>

namespace kagero::test {
namespace {

const unsigned more_than_processors = std::thread::hardware_concurrency() + 1;

TEST(Threads, RunEachTaskInItsOwnThread) {
    std::vector<std::thread::id> ids(more_than_processors);
    run_on_threads(more_than_processors, [&](unsigned i) { ids[i] = std::this_thread::get_id(); });
    EXPECT_EQ(ids[0], std::this_thread::get_id());
    EXPECT_EQ(std::set(ids.begin(), ids.end()).size(), more_than_processors);
}

// run_on_threads starts the threads on different processors. When a task runs, its thread may run on every processor
// that the program may use.
TEST(Threads, HaveTheAffinityOfTheProgram) {
    cpu_set_t before;
    std::vector<cpu_set_t> in_tasks(more_than_processors);
    if (sched_getaffinity(0, sizeof before, &before) != 0)
        GTEST_SKIP() << "cpu_set_t is too small for the processors of this machine";
    run_on_threads(more_than_processors, [&](unsigned i) { sched_getaffinity(0, sizeof in_tasks[i], &in_tasks[i]); });
    for (const cpu_set_t& set : in_tasks) EXPECT_TRUE(CPU_EQUAL(&set, &before));
}

TEST(Threads, KeepTheAffinityToASingleProcessor) {
    cpu_set_t before, single_processor;
    if (sched_getaffinity(0, sizeof before, &before) != 0)
        GTEST_SKIP() << "cpu_set_t is too small for the processors of this machine";
    CPU_ZERO(&single_processor);
    CPU_SET(sched_getcpu(), &single_processor);
    ASSERT_EQ(sched_setaffinity(0, sizeof single_processor, &single_processor), 0);
    cpu_set_t in_tasks[2];
    run_on_threads(2, [&](unsigned i) { sched_getaffinity(0, sizeof in_tasks[i], &in_tasks[i]); });
    sched_setaffinity(0, sizeof before, &before);
    for (const cpu_set_t& set : in_tasks) EXPECT_TRUE(CPU_EQUAL(&set, &single_processor));
}

TEST(Threads, RethrowTheExceptionOfATask) {
    const auto task = [](unsigned i) {
        if (i == 2) throw std::runtime_error("task 2");
    };
    EXPECT_THROW(run_on_threads(3, task), std::runtime_error);
}

}  // namespace
}  // namespace kagero::test
