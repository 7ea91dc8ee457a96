// kagero sweep: traces the same rays for many values of the keys of a scene, and writes their ends as CSV.
#include "sweep/sweep.h"
#include "cli/interrupt.h"
#include "cli/output.h"
#include "cli/ranks/run_on_ranks.h"
#include "cli/ray_options.h"
#include "cli/verb.h"
#include "error.h"
#include "parts/bytes.h"
#include "parts/identity.h"
#include "parts/journals/entry_journal.h"
#include "plan/names.h"
#include "ranks/agreement.h"
#include "ranks/gather_entries.h"
#include "ranks/shared_scene.h"
#include "report/csv/write_rays.h"
#include "report/run_json.h"
#include "report/text/numbers.h"
#include "report/warnings.h"
#include "sweep/sweep_blocks.h"
#include "tuning/resolve.h"

#include <chrono>
#include <ostream>

namespace kagero {

namespace {

void declare_sweep(CLI::App& app, Arguments& arguments) {
    add_scene(app, arguments);
    add_swept_keys(app, arguments);
    add_ray_options(app, arguments);
    add_option(app, "-o,--output", arguments.output,
               "File for the CSV: the columns `set` and one for each key, followed by those of `kagero trace`; '-' is "
               "stdout. Default: -",
               "FILE");
    add_columns(app, arguments, "Each adds a column to the CSV.");
    add_flag(app, "--resume", arguments.resume,
             "Keep finished blocks of rays in the journal OUTPUT.journal, and continue from it if it exists. The "
             "journal is removed when the output is complete. Requires -o");
    add_rank_options(app, arguments, "sweep");
    add_json(app, arguments);
    add_execution(app, arguments);
    add_messages(app, arguments);
}

/// The sums over the finished blocks of a sweep.
struct SweepSums {
    decltype(Counters::ended) ended{};
    decltype(RunReport::failures) failures{};
};

/// A sweep of the command line: its rays in blocks, and their rows of the CSV.
class SweepJob {
public:
    SweepJob(const Arguments& arguments, const Options& options, const std::string& text, const std::string& path,
             std::vector<RayInput> rays)
        : keys_(keys_of_sweep(arguments)), rays_(std::move(rays)),
          sweep_(plan_with(arguments, options, text, path), keys_, rays_.size(), observer_of(arguments)),
          blocks_(sweep_, rays_.size()) {
        if (sweep_.has_separate_plans()) check_scenes_of_sets(scene_with(arguments, options, text, path), keys_);
    }

    const Sweep& sweep() const { return sweep_; }
    std::uint64_t blocks() const { return blocks_.count(); }
    std::size_t rays() const { return rays_.size(); }

    /// Returns what must be the same for a sweep that continues, and for all ranks.
    Properties identity(const Options& options, const Arguments& arguments) const {
        Properties identity = identity_of(sweep_.plan(), options);
        for (const SweptKey& key : keys_) {
            std::string values;
            for (std::size_t set = 0; set < key.count(); ++set) append_to_list(values, key.text(set));
            identity.emplace_back("the list of values of " + key.key, values);
        }
        const std::string_view bytes(reinterpret_cast<const char*>(rays_.data()), rays_.size() * sizeof(RayInput));
        identity.emplace_back("the list of rays",
                              std::to_string(rays_.size()) + " rays with the hash " + std::to_string(checksum(bytes)));
        identity.emplace_back("--observer", arguments.observer);
        identity.emplace_back("the list of columns", arguments.columns);
        return identity;
    }

    /// Traces a block. Returns its sums and rows as JSON; nothing if it was interrupted.
    std::optional<std::string> compute(std::uint64_t index, const std::atomic<bool>* stop) const {
        const SweepBlock block = blocks_.block(index);
        const auto first = rays_.begin() + static_cast<std::ptrdiff_t>(block.first_ray);
        const std::vector<RayInput> rays(first, first + static_cast<std::ptrdiff_t>(block.rays));
        RunControl control;
        control.stop = stop;
        std::vector<RayEnd> ends;
        std::vector<Plan> plans;
        if (!sweep_.trace(block.sets, rays, control, ends, &plans)) return {};
        SweepSums sums;
        std::string rows;
        for (std::size_t i = 0; i < ends.size(); ++i) {
            ++sums.ended[static_cast<int>(ends[i].status)];
            ++sums.failures[static_cast<std::size_t>(ends[i].failure)];
            const std::size_t set = i / block.rays;
            append_set(rows, block.sets.first + set);
            append_end(rows, plans.empty() ? sweep_.plan() : plans[set], block.first_ray + i % block.rays, ends[i]);
        }
        Json json;
        json["ended"] = sums.ended;
        json["failures"] = sums.failures;
        json["rows"] = std::move(rows);
        return json.dump(-1, ' ', false, Json::error_handler_t::replace);
    }

    std::string header() const {
        std::string header = "set";
        for (const SweptKey& key : keys_) header += ',' + csv_text(key.key);
        return header + ',' + header_of_ends(sweep_.plan());
    }

private:
    static SceneWithOverrides scene_with(const Arguments& arguments, const Options& options, const std::string& text,
                                         const std::string& path) {
        return [=](const std::vector<std::string>& overrides) {
            std::vector<Override> all = overrides_of(arguments);
            all.insert(all.end(), overrides.begin(), overrides.end());
            return load_scene_text(text, path, all, catalogue(options.isa), SceneUse::single_rays);
        };
    }
    static PlanWithOverrides plan_with(const Arguments& arguments, Options options, const std::string& text,
                                       const std::string& path) {
        options.energy_error = options.parameter = true;
        options.observer = observer_of(arguments);
        const SceneWithOverrides scene = scene_with(arguments, options, text, path);
        return [=](const std::vector<std::string>& overrides) {
            return resolve(scene(overrides), options, Purpose::ray_list);
        };
    }

    /// Appends the columns of a set.
    void append_set(std::string& row, std::size_t set) const {
        row += std::to_string(set) + ',';
        for (const SweptKey& key : keys_) {
            if (key.texts.empty()) append_exact(row, key.values[set]);
            else row += csv_text(key.texts[set]);
            row += ',';
        }
    }

    std::vector<SweptKey> keys_;
    std::vector<RayInput> rays_;
    Sweep sweep_;
    SweepBlocks blocks_;
};

/// The finished blocks of a sweep, and its report.
struct SweepOutcome {
    std::map<std::uint64_t, Json> blocks;
    std::uint64_t kept = 0;  ///< Number of blocks that an earlier run has traced.
    double seconds = 0;

    RunReport report(const SweepJob& job) const {
        RunReport report;
        for (const auto& [index, block] : blocks)
            for (std::size_t i = 0; i < report.failures.size(); ++i)
                report.failures[i] += block["failures"][i].get<std::uint64_t>();
        for (const auto& [index, block] : blocks)
            for (std::size_t i = 0; i < std::size(report.counters.ended); ++i)
                report.counters.ended[i] += block["ended"][i].get<std::uint64_t>();
        for (const std::uint64_t count : report.counters.ended) report.rays += count;
        report.seconds = seconds;
        report.interrupted = blocks.size() < job.blocks();
        return report;
    }
};

/// Traces the blocks that `outcome` does not contain, on all ranks if `ranks` is not null. `journal` may be null.
void trace_blocks(const SweepJob& job, SweepOutcome& outcome, EntryJournal* journal, Communicator* ranks,
                  const Terminal& terminal) {
    const auto begin = std::chrono::steady_clock::now();
    const auto seconds = [&] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    };
    ProgressLine line(terminal);
    std::vector<std::uint64_t> left;
    for (std::uint64_t i = 0; i < job.blocks(); ++i)
        if (!outcome.blocks.contains(i)) left.push_back(i);
    EntryWork work;
    work.compute = [&](std::uint64_t block, const std::atomic<bool>* stop) { return job.compute(block, stop); };
    work.keep = [&](std::uint64_t block, const std::string& content) {
        Json entry = Json::parse(content);
        if (journal) journal->append(std::to_string(block), entry);
        outcome.blocks[block] = std::move(entry);
    };
    work.progress = [&](double done, double passed) { line.show(done, passed); };
    const std::atomic<bool>* stop = InterruptGuard::requested();
    if (ranks) {
        const std::string bytes =
            share_bytes(*ranks, {reinterpret_cast<const char*>(left.data()), left.size() * sizeof left[0]});
        left.resize(bytes.size() / sizeof left[0]);
        std::copy_n(bytes.data(), bytes.size(), reinterpret_cast<char*>(left.data()));
        compute_on_ranks(*ranks, left, work, stop);
    } else {
        for (std::size_t i = 0; i < left.size() && !*stop; ++i) {
            if (const auto content = work.compute(left[i], stop)) work.keep(left[i], *content);
            work.progress(double(i + 1) / double(left.size()), seconds());
        }
    }
    outcome.seconds = seconds();
}

/// Returns the rays of rank 0, on all ranks.
std::vector<RayInput> share_rays(Communicator& ranks, const std::vector<RayInput>& rays) {
    const std::string bytes =
        share_bytes(ranks, {reinterpret_cast<const char*>(rays.data()), rays.size() * sizeof(RayInput)});
    std::vector<RayInput> shared(bytes.size() / sizeof(RayInput));
    std::copy_n(bytes.data(), bytes.size(), reinterpret_cast<char*>(shared.data()));
    return shared;
}

std::string sweep_json(const SweepJob& job, const SweepOutcome& outcome, const std::vector<Warning>& warnings) {
    const Plan& plan = job.sweep().plan();
    const RunReport report = outcome.report(job);
    const double traced = double(report.rays) * double(outcome.blocks.size() - outcome.kept) /
                          double(std::max<std::size_t>(outcome.blocks.size(), 1));
    Json json;
    json["scene"] = plan.description().path;
    json["isa"] = plan.module().isa;
    json["integrator"] = plan.method().name;
    json["sets"] = job.sweep().sets();
    json["rays_per_set"] = job.rays();
    json["rays"] = report.rays;
    json["seconds"] = outcome.seconds;
    json["ns_per_ray"] = traced > 0 ? Json(1e9 * outcome.seconds / traced) : Json();
    json["reason_against_packets"] = job.sweep().reason_against_packets();
    json["status"] = counts_json(report)["status"];
    json["blocks"] = job.blocks();
    json["blocks_kept"] = outcome.kept;
    json["interrupted"] = report.interrupted;
    json["warnings"] = warnings_json(warnings);
    std::vector<std::string> remarks = job.sweep().plan().remarks;
    remarks.insert(remarks.end(), job.sweep().remarks().begin(), job.sweep().remarks().end());
    json["remarks"] = remarks;
    return text_of(json);
}

/// Writes the CSV and the report, and returns the exit status. With a journal, an interrupted run writes no CSV.
int conclude_sweep(const Arguments& arguments, const SweepJob& job, const SweepOutcome& outcome,
                   std::optional<EntryJournal>& journal, const Terminal& terminal) {
    const RunReport report = outcome.report(job);
    const bool keeps_journal_only = journal && report.interrupted;
    if (!keeps_journal_only && (!arguments.output.empty() || arguments.json != "-"))
        write_output(arguments.output.empty() ? "-" : arguments.output, [&](std::ostream& out) {
            out << job.header();
            for (const auto& [index, block] : outcome.blocks) out << block["rows"].get_ref<const std::string&>();
        });
    if (journal && !report.interrupted) journal->remove();
    const std::vector<Warning> warnings = warnings_of(job.sweep().plan(), report);
    for (const Warning& warning : warnings) terminal.warning(warning.text);
    if (!arguments.json.empty())
        write_output(arguments.json, [&](std::ostream& out) { out << sweep_json(job, outcome, warnings); });
    const std::string count = std::to_string(outcome.blocks.size()) + " of " + std::to_string(job.blocks()) + " blocks";
    terminal.detail(rounded(double(report.rays)) + " rays in " + rounded(outcome.seconds) + " s");
    if (!report.interrupted) return exit_done;
    terminal.note("interrupted; " + (journal ? count + " are in " + journal->path() + "; the same command continues"
                                             : "the rows of " + count + " are written"));
    return exit_interrupted;
}

/// Checks the options and the files. Throws InputError.
void check_sweep(const Arguments& arguments) {
    keys_of_sweep(arguments);
    check_rank_combination(arguments);
    if (!arguments.observer.empty()) require_one_of("--observer", arguments.observer, observer_names());
    if (arguments.output == "-" && arguments.json == "-")
        throw InputError("CSV and JSON cannot both be written to stdout; add a file: --json FILE or -o FILE");
    if (arguments.resume && (arguments.output.empty() || arguments.output == "-"))
        throw InputError("--resume keeps its journal beside the CSV; state a file for it with -o FILE");
}

/// Runs the verb. `ranks` is null without --mpi.
int run_sweep(const Arguments& arguments, const Terminal& terminal, Communicator* ranks) {
    check_sweep(arguments);
    Options options = options_of(arguments);
    request_columns(arguments, options);
    if (ranks) set_up_rank(*ranks, options, terminal);
    if (ranks && ranks->rank() > 0) {
        const ReceivedScene received(*ranks);
        received.check_paths(
            scene_of_text(arguments, options, received.text(), received.path(), SceneUse::single_rays));
        const SweepJob job(arguments, options, received.text(), received.path(), share_rays(*ranks, {}));
        const InterruptGuard interrupts;
        agree_on_properties(*ranks, job.identity(options, arguments));
        SweepOutcome outcome;
        trace_blocks(job, outcome, nullptr, ranks, terminal);
        return exit_done;
    }
    const SceneDescription scene = scene_of(arguments, options, SceneUse::single_rays);
    std::vector<NamedFile> inputs = files_of(scene);
    inputs.emplace_back("--rays", arguments.rays);
    const std::string journal_file = arguments.resume ? arguments.output + ".journal" : "";
    check_outputs({{"-o", arguments.output}, {"--json", arguments.json}, {"the journal", journal_file}}, inputs);
    if (ranks) share_scene(*ranks, scene, arguments.send_files);
    std::vector<RayInput> rays = rays_of(arguments);
    if (ranks) share_rays(*ranks, rays);
    const SweepJob job(arguments, options, scene.text, scene.path, std::move(rays));
    for (const auto* remarks : {&job.sweep().plan().remarks, &job.sweep().remarks()})
        for (const std::string& remark : *remarks) terminal.warning(remark);
    if (!job.sweep().reason_against_packets().empty())
        terminal.detail("packets contain rays of one set only: " + job.sweep().reason_against_packets());
    const Properties identity = job.identity(options, arguments);
    const InterruptGuard interrupts;
    SweepOutcome outcome;
    std::optional<EntryJournal> journal;
    if (arguments.resume) {
        journal.emplace(journal_file, identity);
        for (const auto& [name, entry] : journal->entries()) outcome.blocks[std::stoull(name)] = entry;
        outcome.kept = outcome.blocks.size();
        if (outcome.kept > 0)
            terminal.note("continues from " + journal_file + ": " + std::to_string(outcome.kept) + " of " +
                          std::to_string(job.blocks()) + " blocks are finished");
    }
    if (ranks) agree_on_properties(*ranks, identity);
    trace_blocks(job, outcome, journal ? &*journal : nullptr, ranks, terminal);
    return conclude_sweep(arguments, job, outcome, journal, terminal);
}

int run_sweep(const Arguments& arguments, const Terminal& terminal) {
    if (!arguments.mpi) return run_sweep(arguments, terminal, nullptr);
    return run_on_ranks(arguments, terminal,
                        [](const Arguments& of_rank, const Terminal& terminal_of_rank, Communicator& ranks) {
                            return run_sweep(of_rank, terminal_of_rank, &ranks);
                        });
}

}  // namespace

const Verb sweep_verb{"sweep", "Trace the same rays for many values of the keys of a scene", declare_sweep, run_sweep};

}  // namespace kagero
