// Tests of parts that are damaged, incomplete, or do not belong together.
#include "tests/support/hole_scene.h"
#include "tests/support/part_fixture.h"

#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>

namespace kagero::test {
namespace {

/// A picture of a few rows, whose part file is small enough to be damaged in every byte.
constexpr const char* tiny = R"([space]
hamiltonian = "schwarzschild"
rg = 0.1
[camera]
position = [0, -2, 0]
look_at = [0, 0, 0]
up = [0, 0, 1]
[film]
size = [2, 24]
[sky]
checker = true
)";
constexpr std::size_t tiny_bytes = 4096;
/// Interval of the damaged bytes for which a file is written. Other bytes are read from memory.
constexpr std::size_t file_interval = 16;

class Damage : public PartTest {
protected:
    void SetUp() override {
        PartTest::SetUp();
        options_.schedule = Schedule::scanline;  // Tiles have eight rows.
        options_.threads = 1;
        plan_ = plan_of_text(tiny, {}, options_);
        film_ = film_of(*plan_);
        render_with_errors(*plan_, *film_);
    }
    /// Writes the whole picture as one part, and returns the bytes.
    std::string part_bytes() const {
        const RenderedPart part(*plan_, options_, {});
        EXPECT_EQ(part.results.count(), 3u);
        write_part(path_of("a.part"), part.header, part.results);
        return read("a.part");
    }
    /// Returns the bytes of a complete journal.
    std::string journal_bytes() const {
        const RenderedPart part(*plan_, options_, {});
        std::string bytes = encode_header(part.header);
        for (const auto& [index, record] : part.results.records()) bytes += record;
        return bytes;
    }
    bool is_same_picture(const Film& film) const {
        const std::size_t bytes = std::size_t{film.width()} * film.height() * 3 * sizeof(float);
        return std::memcmp(film.plane("color"), film_->plane("color"), bytes) == 0;
    }
    /// Returns true if the bytes are read as a complete part.
    static bool is_complete_part(const std::string& bytes) {
        std::istringstream in(bytes);
        try {
            const auto header = read_header(in, "the test");
            if (!header) return false;
            Film film = header->film();
            TileResults results;
            return read_tiles(in, *header, film, results).end == TileFileEnd::complete;
        } catch (const InputError&) {
            return false;
        }
    }
    /// Reads the tiles of a journal, from a file if `from_file` is set. Throws InputError.
    void read_journal(const std::string& bytes, bool from_file, Film& film, TileResults& results) const {
        if (from_file) {
            write("a.journal", bytes);
            Journal journal(path_of("a.journal"));
            if (journal.header()) journal.read(film, results);
            return;
        }
        std::istringstream in(bytes);
        if (const auto header = read_header(in, "the test")) read_tiles(in, *header, film, results);
    }
    /// Continues from a journal as `--resume` does. Returns false if it is refused. Expects the right picture
    /// otherwise. `tiles` receives the number of tiles that were read.
    bool continues_rightly(const std::string& bytes, bool from_file, std::uint64_t& tiles) const {
        Film film = film_of(*plan_);
        TileResults results;
        const TileFileHeader header = header_of(*plan_, film, identity_of(*plan_, options_), {});
        try {
            read_journal(bytes, from_file, film, results);
        } catch (const InputError&) {
            return false;
        }
        tiles = results.count();
        RunReport report = render_tiles(*plan_, header, film, results, nullptr, {});
        EXPECT_EQ(report.rays, 48u);
        EXPECT_TRUE(is_same_picture(film));
        return true;
    }

    Options options_;
    std::unique_ptr<Plan> plan_;
    std::optional<Film> film_;
};

TEST_F(Damage, ConcernsFilesOfTheVersionThatTheReferenceStates) {
    std::uint32_t version = 0;
    std::memcpy(&version, part_bytes().data() + 16, sizeof version);
    std::ifstream page(std::string(KAGERO_SOURCE) + "/docs/reference/outputs.md");
    const std::string text{std::istreambuf_iterator<char>(page), {}};
    EXPECT_NE(text.find("| 4 | version of the format: " + std::to_string(version) + " |"), std::string::npos);
}

TEST_F(Damage, OfAPartIsDetectedWhereverItIsCut) {
    const std::string bytes = part_bytes();
    ASSERT_LE(bytes.size(), tiny_bytes);
    EXPECT_TRUE(is_same_picture(merge_parts({path_of("a.part")}, Missing::refused).film));
    EXPECT_TRUE(is_complete_part(bytes));
    for (std::size_t size = 0; size < bytes.size(); ++size) {
        EXPECT_FALSE(is_complete_part(bytes.substr(0, size))) << size << " bytes";
        if (size % file_interval != 0) continue;
        write("cut.part", bytes.substr(0, size));
        EXPECT_THROW(merge_parts({path_of("cut.part")}, Missing::refused), InputError) << size << " bytes";
    }
    write("long.part", bytes + '\0');
    EXPECT_THROW(merge_parts({path_of("long.part")}, Missing::refused), InputError);
}

TEST_F(Damage, OfAPartIsDetectedInEveryBit) {
    const std::string bytes = part_bytes();
    for (std::size_t i = 0; i < bytes.size(); ++i)
        for (int bit = 0; bit < 8; ++bit) {
            std::string flipped = bytes;
            flipped[i] = static_cast<char>(flipped[i] ^ (1 << bit));
            EXPECT_FALSE(is_complete_part(flipped)) << "bit " << bit << " of byte " << i;
        }
}

TEST_F(Damage, OfATileFromAnotherRankIsDetected) {
    const RenderedPart part(*plan_, options_, {});
    const std::string record = part.results.records().begin()->second;
    Film film = part.header.film(Planes::allocated);
    TileResults results;
    const auto is_added = [&](const std::string& bytes) { return add_tile_record(part.header, bytes, film, results); };
    for (std::size_t i = 0; i < record.size(); ++i) {
        EXPECT_FALSE(is_added(record.substr(0, i))) << "cut after " << i << " bytes";
        for (int bit = 0; bit < 8; ++bit) {
            std::string damaged = record;
            damaged[i] = static_cast<char>(damaged[i] ^ 1 << bit);
            EXPECT_FALSE(is_added(damaged)) << "bit " << bit << " of byte " << i;
        }
    }
    EXPECT_FALSE(is_added(record + '\0'));
    EXPECT_TRUE(is_added(record));
    EXPECT_FALSE(is_added(record)) << "the tile is there already";
}

TEST_F(Damage, OfAJournalLosesOnlyTiles) {
    const std::string bytes = journal_bytes();
    ASSERT_LE(bytes.size(), tiny_bytes);
    std::set<std::uint64_t> counts;
    for (std::size_t size = 0; size <= bytes.size(); ++size) {
        std::uint64_t tiles = 0;
        EXPECT_TRUE(continues_rightly(bytes.substr(0, size), size % file_interval == 0, tiles)) << size << " bytes";
        counts.insert(tiles);
    }
    EXPECT_EQ(counts, (std::set<std::uint64_t>{0, 1, 2, 3}));
}

TEST_F(Damage, OfAJournalNeverGivesAWrongPicture) {
    const std::string bytes = journal_bytes();
    std::size_t refused = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        std::string flipped = bytes;
        flipped[i] = static_cast<char>(flipped[i] ^ (1 << i % 8));
        std::uint64_t tiles = 0;
        if (!continues_rightly(flipped, i % file_interval == 0, tiles)) ++refused;
        else EXPECT_LT(tiles, 3u) << "byte " << i;
    }
    EXPECT_GT(refused, 0u);
}

class WrongParts : public HoleTest {
protected:
    void SetUp() override {
        HoleTest::SetUp();
        ASSERT_EQ(run("render hole.toml --quiet --size 100x70 --part 1/2 -o 1.part").status, 0);
        ASSERT_EQ(run("render hole.toml --quiet --size 100x70 --part 2/2 -o 2.part").status, 0);
    }
    /// Expects that a command is refused with a message that contains all these texts, and that it writes nothing.
    void expect_refusal(const std::string& command, const std::vector<std::string>& texts) const {
        const auto before = files();
        const Outcome outcome = run(command);
        EXPECT_EQ(outcome.status, 2) << command;
        for (const std::string& text : texts)
            EXPECT_NE(outcome.err.find(text), std::string::npos) << text << "\nis not in\n" << outcome.err;
        EXPECT_EQ(files(), before) << command;
    }
};

TEST_F(WrongParts, AreRefusedWithTheReason) {
    write("other.toml", std::string(hole) + "# another text\n");
    ASSERT_EQ(run("render other.toml --quiet --size 100x70 --part 2/2 -o scene.part").status, 0);
    ASSERT_EQ(run("render hole.toml --quiet --size 100x71 --part 2/2 -o size.part").status, 0);
    ASSERT_EQ(run("render hole.toml --quiet --size 100x70 --precision float --part 2/2 -o float.part").status, 0);
    ASSERT_EQ(run("render hole.toml --quiet --size 100x70 --part 2/3 -o third.part").status, 0);
    const std::string two = read("2.part");
    write("cut.part", two.substr(0, two.size() / 2));
    write("flipped.part", std::string(two).replace(two.size() / 2, 1, 1, static_cast<char>(~two[two.size() / 2])));
    write("text.part", "not a part");
    expect_refusal("merge 1.part scene.part -o a.exr", {"the scene differs", "1.part", "scene.part", "line 13"});
    expect_refusal("merge 1.part size.part -o a.exr", {"overrides", "[100, 70]", "[100, 71]"});
    expect_refusal("merge 1.part float.part -o a.exr", {"--precision is auto", "but float in float.part"});
    expect_refusal("merge 1.part third.part -o a.exr", {"1.part is part 1/2", "third.part is part 2/3"});
    expect_refusal("merge 1.part 1.part -o a.exr", {"part 1/2 is given twice"});
    expect_refusal("merge 1.part -o a.exr", {"part 2 of 2 is missing", "--incomplete"});
    expect_refusal("merge 1.part cut.part -o a.exr", {"cut.part is incomplete", "tiles", "render the part again"});
    expect_refusal("merge 1.part flipped.part -o a.exr", {"flipped.part is damaged after byte"});
    expect_refusal("merge 1.part text.part -o a.exr", {"text.part is not a part"});
    write("short.part", two.substr(0, 100));
    expect_refusal("merge 1.part short.part -o a.exr", {"short.part is incomplete: it ends within its header"});
    expect_refusal("merge short.part --incomplete -o a.exr", {"short.part is incomplete", "no other part"});
    expect_refusal("merge 1.part missing.part -o a.exr", {"missing.part", "No such file"});
    expect_refusal("merge 1.part 2.part", {"no output"});
    expect_refusal("merge -o a.exr", {"no part"});
    expect_refusal("merge 1.part 2.part -o 2.part", {"are the same file"});
    expect_refusal("merge 1.part 2.part -o a.xyz", {"'.xyz' is not a supported picture format"});
}

TEST_F(WrongParts, AreMergedIfTheUserWantsThem) {
    const std::string two = read("2.part");
    write("cut.part", two.substr(0, two.size() - 3000));
    const Outcome one = run("merge 1.part --incomplete -o one.exr");
    EXPECT_EQ(one.status, 0);
    EXPECT_NE(one.err.find("part 2 of 2 is missing"), std::string::npos) << one.err;
    EXPECT_NE(read("one.exr").find("kagero/interrupted"), std::string::npos);
    const Outcome both = run("merge 1.part cut.part --incomplete -o both.exr");
    EXPECT_EQ(both.status, 0);
    EXPECT_NE(both.err.find("cut.part is incomplete: it contains only "), std::string::npos) << both.err;
    write("empty.part", "");
    const Outcome empty = run("merge empty.part 1.part --incomplete -o empty.exr");
    EXPECT_EQ(empty.status, 0);
    EXPECT_NE(empty.err.find("empty.part is incomplete: it ends within its header"), std::string::npos) << empty.err;
    EXPECT_TRUE(read("empty.exr") == read("one.exr"));
    const Outcome all = run("merge 1.part 2.part --incomplete -o all.exr");
    EXPECT_EQ(read("all.exr").find("kagero/interrupted"), std::string::npos);
}

TEST_F(WrongParts, AreRefusedAsNumbers) {
    for (const char* part : {"3/2", "0/2", "x", "1/0", "1/", "/2", "1/2/3", "-1/2", "1/100001"})
        expect_refusal(std::string("render hole.toml --part ") + part + " -o a.part", {"--part"});
    expect_refusal("render hole.toml --part 3/2 -o a.part", {"'3' is out of range; it must be from 1 to 2"});
    expect_refusal("render hole.toml --part 1/2 --maps -o a.part", {"--part writes no picture"});
    expect_refusal("render hole.toml --part 1/2 --pixel 1,1", {"--pixel"});
}

}  // namespace
}  // namespace kagero::test
