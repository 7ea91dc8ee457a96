#include "study/compare.h"

#include "accuracy/end_errors.h"
#include "error.h"
#include "plan/names.h"
#include "scene/reader.h"
#include "study/compared_kernels.h"
#include "study/equal_error.h"

#include <algorithm>
#include <chrono>
#include <map>

namespace kagero {
namespace {

/// A row of the comparison and the plan that produces it.
struct TimedRow {
    CompareRow row;
    Plan plan;                    ///< Plan with the row's kernel, method and step.
    std::size_t baseline = 0;     ///< Index of the row of the baseline.
    std::vector<double> seconds;  ///< Time to render the picture in each round.
};

/// Returns the arrangement of a packet's pixels as WIDTHxHEIGHT. For a gang of N packets, returns "N of WIDTHxHEIGHT".
/// With `scanlines`, a packet covers adjacent pixels of one row of the picture.
std::string shape_of(const Plan& plan, const KernelInfo& kernel, bool scanlines) {
    if (kernel.form == Form::gang) {
        const KernelInfo& packet =
            *std::find_if(plan.module().kernels, plan.module().kernels + plan.module().kernel_count,
                          [&](const KernelInfo& k) {
                              return k.strategy == kernel.strategy && k.precision == kernel.precision;
                          });
        return std::to_string(kernel.lanes / packet.lanes) + " of " + shape_of(plan, packet, scanlines);
    }
    const std::uint32_t lanes = kernel.lanes;
    const std::uint32_t width = plan.job().camera && !scanlines ? block_width(lanes) : lanes;
    return std::to_string(width) + "x" + std::to_string(lanes / width);
}

/// Runs one comparison.
class Comparer {
public:
    Comparer(const SceneDescription& scene, const CompareOptions& options, const Progress& progress,
             const std::atomic<bool>* stop)
        : options_(options), progress_(progress), stop_(stop), begin_(std::chrono::steady_clock::now()) {
        // The instruction set of the baseline comes first, because the other rows refer to its rows.
        if (!options.baseline.empty()) add_plan(scene, options.baseline);
        for (const std::string& isa : options.isas)
            if (isa != options.baseline) add_plan(scene, isa);
    }
    Comparison run() {
        choose_rows();
        compare_pictures();
        for (unsigned round = 0; round < options_.rounds && !stopped(); ++round) measure_times(round);
        for (TimedRow& timed : rows_) summarize(timed);
        result_.interrupted = stopped();
        return std::move(result_);
    }

private:
    bool stopped() const { return stop_ && stop_->load(std::memory_order_relaxed); }
    void report_progress(double done) const {
        if (progress_)
            progress_(done, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count());
    }
    /// Adds the plan of the scene for one instruction set. The first plan determines the remarks.
    void add_plan(SceneDescription scene, const std::string& isa) {
        scene.integrator.lanes = 0;
        Options options;
        options.isa = isa;
        options.threads = options_.threads;
        plans_.push_back(make_plan(std::move(scene), options));
        const Module& module = plans_.back().module();
        result_.compiler = module.compiler;
        result_.flags.push_back({module.isa, module.flags});
        if (plans_.size() > 1) return;
        result_.remarks = plans_.front().remarks;
        if (plans_.front().description().integrator.max_pixel_error > 0)
            result_.remarks.push_back(
                "integrator.max_pixel_error has no effect on `kagero compare`; use --equal-error to compare kernels at "
                "equal error");
    }
    void choose_rows();
    void add_rows_with_method(const Plan& plan, const std::string& method);
    void add_rows_with_cheapest_methods(const Plan& plan, const Candidates& candidates);
    void add_rows_of_kernel(const Plan& plan, const Variant& variant, const std::string& baseline);
    void check_method(const Plan& plan, const std::string& method) const;
    RunReport render_row(const TimedRow& timed, Film& film) const;
    void compare_pictures();
    void measure_times(unsigned round);
    void summarize(TimedRow& timed);

    const CompareOptions& options_;
    const Progress& progress_;
    const std::atomic<bool>* stop_;
    const std::chrono::steady_clock::time_point begin_;
    std::vector<Plan> plans_;
    std::vector<TimedRow> rows_;
    std::map<std::string, std::size_t> baselines_;  ///< Index of the newest baseline for each method.
    Comparison result_;
};

/// Adds the rows of all selected kernels and methods.
void Comparer::choose_rows() {
    std::vector<const Module*> modules;
    for (const Plan& plan : plans_) modules.push_back(&plan.module());
    check_selection(modules, options_);
    if (options_.equal_error > 0) {
        const Candidates candidates = find_candidates(plans_.front(), options_.equal_error, stop_);
        for (const Plan& plan : plans_) add_rows_with_cheapest_methods(plan, candidates);
        return;
    }
    auto methods = options_.methods;
    if (methods.empty()) methods.push_back(plans_.front().method().name);
    for (const Plan& plan : plans_)
        for (const std::string& method : methods) add_rows_with_method(plan, method);
}

/// Throws InputError if the method does not exist or does not support the space.
void Comparer::check_method(const Plan& plan, const std::string& method) const {
    std::vector<std::string> existing;
    for (std::uint32_t i = 0; i < plan.module().integrator_count; ++i)
        existing.push_back(plan.module().integrators[i].name);
    const auto position = std::find(existing.begin(), existing.end(), method);
    if (position == existing.end())
        throw InputError("--methods: there is no integrator \"" + method + "\"" + suggestion(method, existing));
    if (find_variant(plan, method, Strategy::scalar, Precision::float64, 0)) return;
    if (const char* why = refusal_of(*plan.scene, static_cast<std::uint32_t>(position - existing.begin()), false))
        throw InputError("--methods: " + method + " does not support " + plan.description().space.hamiltonian + ": " +
                         why);
}

/// Adds the rows of the selected kernels, all with the same method.
void Comparer::add_rows_with_method(const Plan& plan, const std::string& method) {
    check_method(plan, method);
    for (const KernelInfo* kernel : compared_kernels(plan.module(), options_)) {
        auto variant = find_variant(plan, method, *kernel, 0);
        if (!variant) {
            const auto integrator =
                find_variant(plan, method, Strategy::scalar, Precision::float64, 0)->method.integrator;
            const char* why = refusal_of(*plan.scene, *kernel, {integrator, plan.run.method.rescaled});
            result_.left_out.push_back({describe_kernel(plan.module(), *kernel) + ", " + method,
                                        why ? why : "it does not support the method"});
            continue;
        }
        const IntegratorDescription& scene = plan.description().integrator;
        variant->step = info_of(plan, *variant).adaptive ? plan.run.tolerance
                        : scene.step_location            ? kernel_step(plan, *variant, scene.step)
                                                         : equivalent_step(plan, *variant);
        add_rows_of_kernel(plan, *variant, method);
    }
}

/// Adds the rows of the selected kernels, each with the cheapest of the candidates for this kernel.
void Comparer::add_rows_with_cheapest_methods(const Plan& plan, const Candidates& candidates) {
    for (const KernelInfo* kernel : compared_kernels(plan.module(), options_)) {
        if (stopped()) return;
        if (kernel->form == Form::gang && options_.lanes.empty()) {
            result_.left_out.push_back(
                {describe_kernel(plan.module(), *kernel),
                 "a gang takes the same steps as its packets; to compare it, select it with --lanes"});
            continue;
        }
        const auto variant = cheapest_for(plan, *kernel, candidates, stop_);
        if (stopped()) return;
        if (variant) {
            add_rows_of_kernel(plan, *variant, "");
        } else if (is_baseline(plan.module(), *kernel, options_)) {
            throw RunError("--equal-error: no method in double precision meets this bound on the error; increase it");
        } else {
            result_.left_out.push_back(
                {describe_kernel(plan.module(), *kernel),
                 "none of the methods that it supports meets the bound on the error"});
        }
    }
}

/// Adds one row or two rows of the variant's kernel. Rows with the same text `baseline` share a baseline.
void Comparer::add_rows_of_kernel(const Plan& plan, const Variant& variant, const std::string& baseline) {
    const KernelInfo& kernel = *variant.kernel;
    if (is_baseline(plan.module(), kernel, options_)) baselines_[baseline] = rows_.size();
    TimedRow timed{{}, plan_with_variant(plan, variant), baselines_.at(baseline), {}};
    CompareRow& row = timed.row;
    row.isa = plan.module().isa;
    row.kernel = &kernel;
    row.method = info_of(plan, variant).name;
    row.step = stated_step(plan, variant);
    row.solver_tolerance = variant.solver_tolerance >= 0 ? variant.solver_tolerance : plan.run.solver_tolerance;
    row.shape = shape_of(plan, kernel, false);
    rows_.push_back(timed);
    // The second row of a kernel measures packets that cover adjacent pixels of one row of the picture, as in Satoh
    // (2003). It is added only for kernels that support every space, and whose packets are not wider than a tile.
    constexpr std::uint32_t tile_width = 32;
    if (kernel.strategy != Strategy::packet || kernel.refusal || kernel.lanes > tile_width || !plan.job().camera)
        return;
    timed.plan.run.scanlines = true;
    row.shape = shape_of(plan, kernel, true);
    rows_.push_back(timed);
}

RunReport Comparer::render_row(const TimedRow& timed, Film& film) const {
    return render_with_errors(timed.plan, film, {.stop = stop_});
}

/// Renders every row once and compares its picture with that of the baseline. This run also warms up caches and clock
/// rates.
void Comparer::compare_pictures() {
    std::map<std::size_t, Film> films;
    const auto is_needed = [&](std::size_t baseline, std::size_t row) {
        return std::any_of(rows_.begin() + std::ptrdiff_t(row), rows_.end(),
                           [&](const TimedRow& timed) { return timed.baseline == baseline; });
    };
    for (std::size_t i = 0; i < rows_.size() && !stopped(); ++i) {
        TimedRow& timed = rows_[i];
        const FilmDescription& size = timed.plan.description().film;
        Film film(size.width, size.height, {"color", "status", "object"});
        const RunReport report = render_row(timed, film);
        if (report.interrupted) return;
        timed.row.rendered = true;
        result_.rays = report.rays;
        const Counters& work = report.counters;
        if (work.issued_lane_steps)
            timed.row.occupancy = double(work.active_lane_steps) / double(work.issued_lane_steps);
        if (timed.baseline == i) {
            std::erase_if(films, [&](const auto& kept) { return !is_needed(kept.first, i); });
            films.emplace(i, std::move(film));
            continue;
        }
        const Film& expected = films.at(timed.baseline);
        const auto value = [](const Film& f, const char* layer, std::size_t k) { return f.plane(layer)[k]; };
        for (std::size_t k = 0; k < std::size_t(size.width) * size.height; ++k) {
            const bool is_flip = value(expected, "status", k) != value(film, "status", k) ||
                                 value(expected, "object", k) != value(film, "object", k);
            if (is_flip) ++timed.row.flips;
            for (std::size_t c = 0; !is_flip && c < 3; ++c)
                timed.row.max_difference =
                    std::max(timed.row.max_difference,
                             double(std::abs(value(expected, "color", 3 * k + c) - value(film, "color", 3 * k + c))));
        }
        report_progress(double(i + 1) / double(rows_.size() * (options_.rounds + 1)));
    }
}

/// Renders every row once and stores the times.
void Comparer::measure_times(unsigned round) {
    const double all_renders = double(rows_.size() * (options_.rounds + 1));
    for (std::size_t i = 0; i < rows_.size(); ++i) {
        const FilmDescription& film = rows_[i].plan.description().film;
        Film picture(film.width, film.height, film.layers);
        const RunReport report = render_row(rows_[i], picture);
        if (stopped()) return;
        rows_[i].seconds.push_back(report.seconds);
        report_progress(double(rows_.size() * (round + 1) + i + 1) / all_renders);
    }
    ++result_.rounds;
}

/// Computes the statistics of a row from its times and adds it to the result.
void Comparer::summarize(TimedRow& timed) {
    const auto& baseline = rows_[timed.baseline].seconds;
    timed.seconds.resize(result_.rounds);  // Removes the time of an interrupted round.
    std::vector<double> ratios;
    for (unsigned round = 0; round < result_.rounds; ++round) ratios.push_back(baseline[round] / timed.seconds[round]);
    timed.row.speedup = timing_of(ratios).median;
    timed.row.seconds = timing_of(timed.seconds);
    timed.row.samples = timed.seconds;
    timed.row.rays_per_second = double(result_.rays) / timed.row.seconds.median;
    result_.rows.push_back(timed.row);
}

}  // namespace

Comparison compare(const SceneDescription& scene, const CompareOptions& options, const Progress& progress,
                   const std::atomic<bool>* stop) {
    return Comparer(scene, options, progress, stop).run();
}

}  // namespace kagero
