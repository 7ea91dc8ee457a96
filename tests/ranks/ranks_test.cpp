// Tests of the exchange between ranks: results, failures, lost ranks and agreements. The ranks are threads.
#include "ranks/agreement.h"
#include "ranks/gather_tiles.h"
#include "ranks/joint_work.h"
#include "ranks/shared_scene.h"
#include "ranks/shared_tiles.h"
#include "ranks/tile_supply.h"
#include "scene/load/load.h"
#include "tests/support/local_ranks.h"
#include "tests/support/part_fixture.h"

#include <map>
#include <numeric>
#include <set>
#include <thread>

namespace kagero::test {
namespace {

/// Returns the message of the exception in flight.
std::string message_in_flight() {
    try {
        throw;
    } catch (const AgreedFailure& failure) {
        return "agreed: " + failure.failure().message;
    } catch (const LostRank& error) {
        return std::string("lost: ") + error.what();
    } catch (const std::exception& error) {
        return error.what();
    }
}

std::vector<std::string> run_on(int count, const std::function<void(Communicator&)>& work) {
    return run_ranks(count, work, message_in_flight);
}

constexpr LinkTimes quick{1e-4, 0.02, 0.5};

class Ranks : public PartTest {
protected:
    static Plan plan(const Options& options) {
        const std::string scene = std::string(KAGERO_SCENES) + "/hole.toml";
        const Overrides overrides{{"film.size=[160, 100]"}, {"film.layers=[\"color\", \"steps\"]"}};
        return resolve(load_scene(scene, overrides, catalogue("auto")), options);
    }
};

// The bytes of one uninterrupted render are the reference.
TEST_F(Ranks, GiveTheSamePictureForAnyNumber) {
    Options options;
    options.threads = 1;
    options.energy_error = true;
    const Plan whole = plan(options);
    const std::string expected = render_at_once(whole);
    for (const int count : {1, 2, 5, 31}) {
        const auto failures = run_on(count, [&](Communicator& ranks) {
            Film film = film_of(whole);
            const TileFileHeader header = header_of(whole, film, identity_of(whole, options), {});
            TileResults results;
            const RunReport report = render_on_ranks(ranks, whole, header, film, results, nullptr, {}, quick);
            if (ranks.rank() > 0) return;
            EXPECT_EQ(report.ranks.size(), static_cast<std::size_t>(count));
            EXPECT_FALSE(report.interrupted);
            write_film(film, path_of("ranks.exr"), picture_metadata(whole, report));
        });
        EXPECT_EQ(failures, std::vector<std::string>(static_cast<std::size_t>(count)));
        EXPECT_TRUE(read("ranks.exr") == expected) << count << " ranks";
    }
}

// A rank that never answers is lost. The journal keeps all tiles but those that were given to it before the render.
TEST_F(Ranks, KeepTheJournalIfOneIsLost) {
    Options options;
    options.threads = 1;
    const Plan whole = plan(options);
    const auto failures = run_on(2, [&](Communicator& ranks) {
        if (ranks.rank() > 0) return;
        Film film = film_of(whole);
        const TileFileHeader header = header_of(whole, film, identity_of(whole, options), {});
        TileResults results;
        Journal journal(path_of("journal"));
        journal.begin(header);
        render_on_ranks(ranks, whole, header, film, results, &journal, {}, quick);
    });
    EXPECT_EQ(failures[0].find("lost: rank 1 is lost"), 0u) << failures[0];
    Journal journal(path_of("journal"));
    ASSERT_TRUE(journal.header());
    Film film = journal.header()->film();
    TileResults results;
    EXPECT_EQ(journal.read(film, results), 0u);
    const std::uint64_t tiles = journal.header()->grid.count(), of_lost_rank = (tiles + 1) / 2 / 2;
    EXPECT_GT(of_lost_rank, 0u);
    EXPECT_EQ(results.count(), tiles - of_lost_rank);
}

// Rank 1 answers requests as the link does, from another thread. Each of its tiles takes three times as long.
TEST(TileSupply, GivesEveryTileOnceAndMoreOfThemToFasterRanks) {
    constexpr std::uint64_t tiles = 400;
    std::vector<std::uint64_t> left(tiles);
    std::iota(left.begin(), left.end(), 0);
    TileSupply root(2, left, {});
    std::atomic<int> requests = 0;
    const std::atomic<bool> stop = false;
    TileSupply other(2, {}, [&](std::size_t) { ++requests; });
    std::atomic<bool> is_done = false;
    std::thread link([&] {
        while (!is_done) {
            for (; requests > 0; --requests) other.receive(root.take_share(4));
            std::this_thread::sleep_for(std::chrono::microseconds(200));
        }
    });
    std::vector<std::uint64_t> of_root, of_other;
    const auto render = [&](TileSupply& supply, std::vector<std::uint64_t>& rendered, int microseconds) {
        while (const auto tile = supply.next(stop)) {
            rendered.push_back(*tile);
            std::this_thread::sleep_for(std::chrono::microseconds(microseconds));
        }
    };
    std::thread slow([&] { render(other, of_other, 600); });
    render(root, of_root, 200);
    slow.join();
    is_done = true;
    link.join();
    EXPECT_GT(of_root.size(), of_other.size());
    EXPECT_GT(of_other.size(), tiles / 20);
    std::vector<std::uint64_t> all = of_root;
    all.insert(all.end(), of_other.begin(), of_other.end());
    std::sort(all.begin(), all.end());
    EXPECT_EQ(all, left);
}

TEST(TileSupply, RequestsSharesBeforeTheyAreNeeded) {
    const std::atomic<bool> stop = false;
    int requests = 0;
    TileSupply other(2, {}, [&](std::size_t) { ++requests; });
    other.request_first();
    EXPECT_EQ(requests, 1);
    other.receive({1, 2, 3, 4, 5, 6, 7, 8});
    for (const std::uint64_t tile : {1, 2, 3, 4}) EXPECT_EQ(other.next(stop), tile);
    EXPECT_EQ(requests, 1);
    EXPECT_EQ(other.next(stop), 5u);
    EXPECT_EQ(requests, 2);

    std::vector<std::uint64_t> left(32);
    TileSupply root(2, left, {});
    EXPECT_FALSE(root.is_short());
    for (const std::size_t size : {8, 6, 4}) EXPECT_EQ(root.take_share(4).size(), size);
    EXPECT_TRUE(root.is_short());
}

TEST(TileSupply, EndsIfTheRunIsStopped) {
    const std::atomic<bool> stop = true;
    TileSupply other(2, {}, [](std::size_t) {});
    EXPECT_FALSE(other.next(stop));
}

TEST_F(Ranks, EndIfOneFails) {
    const auto failures = run_on(3, [&](Communicator& ranks) {
        JointWork work(ranks, nullptr, quick);
        work.run([&]() -> std::string {
            if (ranks.rank() == 2) throw RunError("no memory here");
            while (!*work.stop()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
            return "";
        });
    });
    EXPECT_EQ(failures[0], "rank 2 on host host-2: no memory here");
    EXPECT_EQ(failures[1], "");
    EXPECT_EQ(failures[2], "no memory here");
}

// Results of several threads are sent together, in messages that differ in size. Some results have no bytes.
TEST_F(Ranks, SendEveryResultOnce) {
    constexpr int results_per_thread = 500;
    std::map<int, std::multiset<std::string>> received;
    const auto failures = run_on(3, [&](Communicator& ranks) {
        const auto post_results = [&](JointWork& work, int thread) {
            for (int i = 0; i < results_per_thread; ++i) {
                work.post_result(std::string(static_cast<std::size_t>(i % 7 * i), static_cast<char>('a' + thread)));
                if (i % 100 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
            }
        };
        JointWork work(ranks, nullptr, quick);
        work.receive_result = [&](int from, std::string_view result) { received[from].emplace(result); };
        work.run([&] {
            if (ranks.rank() == 0) return std::string();
            std::thread other(post_results, std::ref(work), 0);
            post_results(work, 1);
            other.join();
            return std::string();
        });
    });
    EXPECT_EQ(failures, std::vector<std::string>(3));
    std::multiset<std::string> expected;
    for (const char letter : {'a', 'b'})
        for (int i = 0; i < results_per_thread; ++i)
            expected.insert(std::string(static_cast<std::size_t>(i % 7 * i), letter));
    for (const int rank : {1, 2}) EXPECT_TRUE(received[rank] == expected) << rank;
}

TEST_F(Ranks, EndIfResultsCannotBeKept) {
    const auto failures = run_on(3, [&](Communicator& ranks) {
        JointWork work(ranks, nullptr, quick);
        work.receive_result = [](int, std::string_view) { throw RunError("the disk is full"); };
        work.run([&]() -> std::string {
            if (ranks.rank() == 1) work.post_result("a result");
            while (!*work.stop()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
            return "";
        });
    });
    EXPECT_EQ(failures, (std::vector<std::string>{"the disk is full", "", ""}));
}

// Each rank can be the one that receives the signal.
TEST_F(Ranks, StopIfOneIsStopped) {
    for (int stopped = 0; stopped < 3; ++stopped) {
        std::atomic<bool> stop = false;
        const auto failures = run_on(3, [&](Communicator& ranks) {
            JointWork work(ranks, ranks.rank() == stopped ? &stop : nullptr, quick);
            const std::vector<std::string> ends = work.run([&] {
                if (ranks.rank() == stopped) stop = true;
                while (!*work.stop()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
                return "end of " + std::to_string(ranks.rank());
            });
            if (ranks.rank() == 0) {
                EXPECT_EQ(ends, (std::vector<std::string>{"end of 0", "end of 1", "end of 2"}));
            }
        });
        EXPECT_EQ(failures, std::vector<std::string>(3));
    }
}

TEST_F(Ranks, AgreeOnTheFirstFailure) {
    const auto failures = run_on(4, [&](Communicator& ranks) {
        agree(ranks);
        const RankFailure failure{RankFailure::Kind::wrong_input, "reason " + std::to_string(ranks.rank())};
        agree(ranks, ranks.rank() >= 2 ? failure : RankFailure{});
    });
    EXPECT_EQ(failures, std::vector<std::string>(4, "agreed: rank 2 on host host-2: reason 2"));
}

TEST_F(Ranks, UseTheBestCommonInstructionSet) {
    const auto failures = run_on(3, [&](Communicator& ranks) {
        const RankSetup setup = agree_on_setup(ranks, ranks.rank() == 1 ? "sse2" : "auto", 3);
        EXPECT_EQ(setup.isa, "sse2");
        EXPECT_EQ(setup.threads, 3u);
        const bool same = find_isa_names("all").front() == "sse2";
        EXPECT_EQ(setup.remark.find("different instruction sets") != std::string::npos, !same) << setup.remark;
    });
    // Without a module for SSE2, the ranks have no instruction set in common.
    if (const auto isas = find_isa_names("all"); std::find(isas.begin(), isas.end(), "sse2") != isas.end()) {
        EXPECT_EQ(failures, std::vector<std::string>(3));
    } else {
        for (const std::string& failure : failures) EXPECT_NE(failure.find("in common"), std::string::npos) << failure;
    }
}

TEST_F(Ranks, RefuseAnotherInput) {
    Options options;
    options.threads = 1;
    const Plan whole = plan(options);
    const auto failures = run_on(2, [&](Communicator& ranks) {
        Properties identity = identity_of(whole, options);
        const Film film = film_of(whole);
        if (ranks.rank() == 0) return share_tiles(ranks, header_of(whole, film, identity, {}), TileResults());
        identity.emplace_back("the content of the texture of sky", "5 bytes");
        try {
            receive_tiles(ranks, identity);
            ADD_FAILURE() << "another identity was accepted";
        } catch (...) {
            agree(ranks, failure_in_flight());
        }
    });
    for (const std::string& failure : failures)
        EXPECT_NE(failure.find("the content of the texture of sky is stated in this rank, but not in rank 0"),
                  std::string::npos)
            << failure;
}

// The files of rank 1 are copies in another folder, with the same content, below which the scene finds them.
TEST_F(Ranks, ReceiveFiles) {
    std::filesystem::create_directories(directory_ / "textures");
    write("textures/sky.jpg", text_of(std::string(KAGERO_SCENES) + "/textures/milkyway.jpg"));
    write("scene.toml",
          "[space]\nhamiltonian = \"flat\"\n[camera]\nposition = [0, 0, 0]\nlook_at = [1, 0, 0]\nup = [0, 0, 1]\n"
          "[film]\nsize = [8, 8]\n[sky]\ntexture = \"textures/sky.jpg\"\n");
    std::string copy;
    const auto failures = run_on(2, [&](Communicator& ranks) {
        if (ranks.rank() == 0)
            return share_scene(ranks, load_scene(path_of("scene.toml"), {}, catalogue("auto")), true);
        const ReceivedScene received(ranks);
        const SceneDescription scene = load_scene_text(received.text(), received.path(), {}, catalogue("auto"));
        received.check_paths(scene);
        copy = scene.sky.paint.texture;
        EXPECT_NE(copy, path_of("textures/sky.jpg"));
        EXPECT_TRUE(text_of(copy) == read("textures/sky.jpg"));
    });
    EXPECT_EQ(failures, std::vector<std::string>(2));
    EXPECT_FALSE(copy.empty());
    EXPECT_FALSE(std::filesystem::exists(copy)) << "the copy was not removed";
}

}  // namespace
}  // namespace kagero::test
