#include "study/compare/compare.h"

#include "accuracy/end_errors.h"
#include "error.h"
#include "plan/names.h"
#include "scene/reader.h"
#include "study/compare/compared_kernels.h"
#include "study/compare/compared_plans.h"
#include "study/compare/equal_error.h"

#include <algorithm>
#include <chrono>
#include <cmath>
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
    const std::uint32_t lanes = kernel.lanes, width = plan.job().camera && !scanlines ? block_width(lanes) : lanes;
    return std::to_string(width) + "x" + std::to_string(lanes / width);
}

/// Sets CompareRow::flips and max_difference of a row from its picture and that of its baseline.
void compare_films(const Film& expected, const Film& film, CompareRow& row) {
    const auto differ = [&](const char* layer, std::size_t pixel) {
        return expected.plane(layer)[pixel] != film.plane(layer)[pixel];
    };
    const float *expected_colors = expected.plane("color"), *colors = film.plane("color");
    for (std::size_t pixel = 0; pixel < std::size_t(film.width()) * film.height(); ++pixel) {
        if (differ("status", pixel) || differ("object", pixel)) {
            ++row.flips;
            continue;
        }
        for (std::size_t k = 3 * pixel; k < 3 * pixel + 3; ++k)
            row.max_difference = std::max(row.max_difference, double(std::abs(expected_colors[k] - colors[k])));
    }
}

/// Runs one comparison.
class Comparer {
public:
    Comparer(const SceneDescription& scene, const CompareOptions& options, const Progress& progress,
             const std::atomic<bool>* stop)
        : options_(options), progress_(progress), stop_(stop), begin_(std::chrono::steady_clock::now()) {
        // The instruction set of the baseline comes first, because the other rows refer to its rows.
        if (!options.baseline.empty()) add_plans(scene, options.baseline);
        for (const std::string& isa : options.isas)
            if (isa != options.baseline) add_plans(scene, isa);
    }
    Comparison run() {
        choose_rows();
        compare_pictures();
        for (unsigned round = 0; round < options_.rounds && !stopped(); ++round) measure_times(round);
        for (TimedRow& timed : rows_) summarize(timed);
        result_.interrupted = stopped();
        return std::move(result_);
    }
    /// Returns the time in seconds in which every row renders the picture once.
    double seconds_per_round() {
        choose_rows();
        compare_pictures();
        const auto begin = std::chrono::steady_clock::now();
        measure_times(0);
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    }

private:
    bool stopped() const { return stop_ && stop_->load(std::memory_order_relaxed); }
    void report_progress(double done) const {
        if (progress_)
            progress_(done, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count());
    }
    /// Adds the plans of the scene for one instruction set. The first plan determines the remarks.
    void add_plans(const SceneDescription& scene, const std::string& isa) {
        Options options;
        options.isa = isa;
        options.threads = options_.threads;
        for (ComparedPlan& compared : plans_for_comparison(scene, options, result_.left_out))
            plans_.push_back(std::move(compared));
        const Module& module = plans_.back().plan.module();
        result_.compiler = module.compiler;
        result_.flags.push_back({module.isa, module.flags});
        if (result_.flags.size() > 1) return;
        const Plan& plan = plans_.front().plan;
        result_.width = plan.description().film.width;
        result_.height = plan.description().film.height;
        result_.remarks = plan.remarks;
        if (plan.description().integrator.max_pixel_error > 0)
            result_.remarks.push_back(
                "integrator.max_pixel_error has no effect on `kagero compare`; use --equal-error to compare kernels at "
                "equal error");
    }
    void choose_rows();
    void add_rows_with_method(const ComparedPlan& compared, const std::string& method);
    void add_rows_with_cheapest_methods(const ComparedPlan& compared, const Candidates& candidates);
    void add_rows_of_kernel(const ComparedPlan& compared, const Variant& variant, const std::string& baseline);
    std::vector<const KernelInfo*> kernels_of(const ComparedPlan& compared) const;
    void leave_out(const ComparedPlan& compared, const KernelInfo& kernel, const std::string& method,
                   const std::string& why);
    bool is_baseline_row(const ComparedPlan& compared, const KernelInfo& kernel) const {
        return !compared.supplements && is_baseline(compared.plan.module(), kernel, options_);
    }
    void check_method(const Plan& plan, const std::string& method) const;
    RunReport render_row(const TimedRow& timed, Film& film) const;
    void compare_pictures();
    void measure_times(unsigned round);
    void summarize(TimedRow& timed);

    const CompareOptions& options_;
    const Progress& progress_;
    const std::atomic<bool>* stop_;
    const std::chrono::steady_clock::time_point begin_;
    std::vector<ComparedPlan> plans_;
    std::vector<TimedRow> rows_;
    std::map<std::string, std::size_t> baselines_;  ///< Index of the newest baseline for each method.
    Comparison result_;
};

/// Adds the rows of all selected kernels and methods.
void Comparer::choose_rows() {
    std::vector<const Module*> modules;
    for (const ComparedPlan& compared : plans_)
        if (!compared.supplements) modules.push_back(&compared.plan.module());
    check_selection(modules, options_);
    if (options_.equal_error > 0) {
        const Candidates candidates = find_candidates(plans_.front().plan, options_.equal_error, stop_);
        for (const ComparedPlan& compared : plans_) add_rows_with_cheapest_methods(compared, candidates);
        return;
    }
    auto methods = options_.methods;
    if (methods.empty()) methods.push_back(plans_.front().plan.method().name);
    for (const ComparedPlan& compared : plans_)
        for (const std::string& method : methods) add_rows_with_method(compared, method);
}

/// Returns the selected kernels of a plan. A supplement has only kernels for which machine code can be generated.
std::vector<const KernelInfo*> Comparer::kernels_of(const ComparedPlan& compared) const {
    std::vector<const KernelInfo*> kernels = compared_kernels(compared.plan.module(), options_);
    if (compared.supplements)
        std::erase_if(kernels, [&](const KernelInfo* kernel) { return !can_supplement(*kernel); });
    return kernels;
}

/// Reports that a kernel is not compared, unless a supplement of its plan contains it.
void Comparer::leave_out(const ComparedPlan& compared, const KernelInfo& kernel, const std::string& method,
                         const std::string& why) {
    const Module& module = compared.plan.module();
    const bool is_supplemented = std::any_of(plans_.begin(), plans_.end(), [&](const ComparedPlan& other) {
        return other.supplements && &other.plan.module() == &module;
    });
    if (is_supplemented && !compared.supplements && can_supplement(kernel)) return;
    result_.left_out.push_back({describe_kernel(module, kernel) + (method.empty() ? "" : ", " + method), why});
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
void Comparer::add_rows_with_method(const ComparedPlan& compared, const std::string& method) {
    const Plan& plan = compared.plan;
    if (!compared.supplements) check_method(plan, method);
    for (const KernelInfo* kernel : kernels_of(compared)) {
        auto variant = find_variant(plan, method, *kernel, 0);
        if (!variant) {
            leave_out(compared, *kernel, method, why_unsupported(plan, *kernel, method));
            continue;
        }
        const IntegratorDescription& scene = plan.description().integrator;
        variant->step = info_of(plan, *variant).adaptive ? plan.run.tolerance
                        : scene.step_location            ? kernel_step(plan, *variant, scene.step)
                                                         : equivalent_step(plan, *variant);
        add_rows_of_kernel(compared, *variant, method);
    }
}

/// Adds the rows of the selected kernels, each with the cheapest of the candidates for this kernel.
void Comparer::add_rows_with_cheapest_methods(const ComparedPlan& compared, const Candidates& candidates) {
    const Plan& plan = compared.plan;
    for (const KernelInfo* kernel : kernels_of(compared)) {
        if (stopped()) return;
        if (kernel->form == Form::gang && options_.lanes.empty()) {
            leave_out(compared, *kernel, "",
                      "a gang takes the same steps as its packets; to compare it, select it with --lanes");
            continue;
        }
        const auto variant = cheapest_for(plan, *kernel, candidates, stop_);
        if (stopped()) return;
        if (variant) {
            add_rows_of_kernel(compared, *variant, "");
        } else if (is_baseline_row(compared, *kernel)) {
            throw RunError("--equal-error: no method in double precision meets this bound on the error; increase it");
        } else {
            leave_out(compared, *kernel, "", "none of the methods that it supports meets the bound on the error");
        }
    }
}

/// Adds one row or two rows of the variant's kernel. Rows with the same text `baseline` share a baseline.
void Comparer::add_rows_of_kernel(const ComparedPlan& compared, const Variant& variant, const std::string& baseline) {
    const Plan& plan = compared.plan;
    const KernelInfo& kernel = *variant.kernel;
    if (is_baseline_row(compared, kernel)) baselines_[baseline] = rows_.size();
    TimedRow timed{{}, plan_with_variant(plan, variant), baselines_.at(baseline), {}};
    CompareRow& row = timed.row;
    row.isa = plan.module().isa;
    row.kernel = &kernel;
    row.code = code_of(*plan.scene);
    row.method = info_of(plan, variant).name;
    row.step = stated_step(plan, variant);
    row.solver_tolerance = variant.solver_tolerance >= 0 ? variant.solver_tolerance : plan.run.solver_tolerance;
    row.shape = shape_of(plan, kernel, false);
    rows_.push_back(timed);
    // The second row of a kernel measures packets that cover adjacent pixels of one row of the picture, as in Satoh
    // (2003). It is added only for kernels that support every space, and whose packets are not wider than a tile.
    constexpr std::uint32_t tile_width = 32;
    if (kernel.strategy != Strategy::packet || kernel.refusal || kernel.lanes > tile_width || !plan.job().camera ||
        compared.supplements)
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
        compare_films(films.at(timed.baseline), film, timed.row);
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

/// Returns the scene with a film of about the given number of pixels and the same aspect ratio.
SceneDescription resized(SceneDescription scene, double pixels) {
    const double factor = std::sqrt(pixels / (double(scene.film.width) * scene.film.height));
    const auto scaled = [&](std::uint32_t size) { return std::max(1u, std::uint32_t(std::lround(factor * size))); };
    scene.film.width = scaled(scene.film.width);
    scene.film.height = scaled(scene.film.height);
    return scene;
}

/// Returns the scene with a film so small that the comparison takes about options.max_seconds, which is estimated from
/// films of a few rays, and then of more as long as these take little time.
SceneDescription with_affordable_film(const SceneDescription& scene, const CompareOptions& options,
                                      const std::atomic<bool>* stop) {
    constexpr double first_rays = 64, growth = 8, last_pixels = 1024, share_of_time = 0.05;
    const double pixels = double(scene.film.width) * scene.film.height;
    if (!(options.max_seconds > 0) || options.equal_error > 0 || pixels * scene.film.spp <= first_rays) return scene;
    for (double trial_pixels = first_rays / scene.film.spp;; trial_pixels *= growth) {
        const SceneDescription small = resized(scene, trial_pixels);
        const double small_pixels = double(small.film.width) * small.film.height,
                     seconds_per_round = Comparer(small, options, {}, stop).seconds_per_round();
        if (stop && *stop) return small;
        if (seconds_per_round < share_of_time * options.max_seconds && small_pixels < std::min(last_pixels, pixels))
            continue;
        const double seconds = seconds_per_round * (options.rounds + 1);  // one more round compares the pictures
        const double affordable = small_pixels * options.max_seconds / seconds;
        return affordable < pixels ? resized(scene, affordable) : scene;
    }
}

}  // namespace

Comparison compare(const SceneDescription& scene, const CompareOptions& options, const Progress& progress,
                   const std::atomic<bool>* stop) {
    return Comparer(with_affordable_film(scene, options, stop), options, progress, stop).run();
}

}  // namespace kagero
