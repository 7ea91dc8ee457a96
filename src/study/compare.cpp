#include "study/compare.h"

#include "accuracy/end_errors.h"
#include "error.h"
#include "plan/names.h"
#include "scene/reader.h"
#include "study/equal_error.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <set>

namespace kagero {
namespace {

/// One row with what is needed to run it.
struct Runner {
    CompareRow row;
    Plan plan;  ///< by the row's kernel, method and step
    std::size_t yardstick = 0;  ///< which runner it is compared with
    std::vector<double> seconds;
};

bool is_yardstick(const KernelInfo& kernel) {
    return kernel.strategy == Strategy::scalar && kernel.form == Form::none && kernel.precision == Precision::float64;
}

/// The pixels of a packet, as the tracing loop arranges them; of a gang, its packets.
std::string shape_of(const Plan& plan, const KernelInfo& kernel, bool scanlines) {
    if (kernel.form == Form::gang) {
        const KernelInfo& packet =
            *std::find_if(plan.module().kernels, plan.module().kernels + plan.module().kernel_count,
                          [&](const KernelInfo& k) {
                              return k.strategy == kernel.strategy && k.precision == kernel.precision;
                          });
        return std::to_string(kernel.lanes / packet.lanes) + " of " + shape_of(plan, packet, scanlines);
    }
    const std::uint32_t lanes = kernel.lanes, wide = block_width(lanes);
    const bool blocks = plan.job().camera && !scanlines;
    return blocks ? std::to_string(wide) + "x" + std::to_string(lanes / wide) : std::to_string(lanes) + "x1";
}

class Comparer {
public:
    Comparer(const SceneDescription& scene, const CompareOptions& options, const Progress& progress,
             const std::atomic<bool>* stop)
        : options_(options), progress_(progress), stop_(stop), begin_(std::chrono::steady_clock::now()) {
        for (const std::string& isa : options.isas) add_plan(scene, isa);
    }
    Comparison run() {
        choose_rows();
        compare_pictures();
        for (unsigned round = 0; round < options_.rounds && !stopped(); ++round) take_times(round);
        for (Runner& runner : runners_) finish(runner);
        result_.interrupted = stopped();
        return std::move(result_);
    }

private:
    bool stopped() const { return stop_ && stop_->load(std::memory_order_relaxed); }
    void tell(double done) const {
        if (progress_)
            progress_(done, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count());
    }
    void add_plan(SceneDescription scene, const std::string& isa) {
        scene.integrator.lanes = 0;
        Options options;
        options.isa = isa, options.threads = options_.threads;
        plans_.push_back(make_plan(std::move(scene), options));
        result_.compiler = plans_.back().module().compiler;
        if (plans_.size() > 1) return;
        result_.remarks = plans_.front().remarks;
        if (plans_.front().description().integrator.max_pixel_error > 0)
            result_.remarks.push_back("integrator.max_pixel_error has no effect on a comparison; --equal-error has");
    }
    bool wanted(const KernelInfo& kernel) const;
    void choose_rows();
    void choose_by_method(const Plan& plan, const std::string& method);
    void choose_by_error(const Plan& plan, const Candidates& candidates);
    void add(const Plan& plan, const Variant& variant, std::size_t& yardstick);
    void check_lanes() const;
    void check_wanted() const;
    void check_method(const Plan& plan, const std::string& method) const;
    RunReport draw(const Runner& runner, Film& film) const;
    void compare_pictures();
    void take_times(unsigned round);
    void finish(Runner& runner);

    const CompareOptions& options_;
    const Progress& progress_;
    const std::atomic<bool>* stop_;
    const std::chrono::steady_clock::time_point begin_;
    std::vector<Plan> plans_;
    std::vector<Runner> runners_;
    Comparison result_;
};

bool Comparer::wanted(const KernelInfo& kernel) const {
    if (options_.strategy && kernel.strategy != *options_.strategy) return false;
    if (options_.precision && kernel.precision != *options_.precision) return false;
    if (kernel.strategy == Strategy::per_ray) return true;
    // Unasked no gang that is as short as a packet may be.
    constexpr std::uint32_t longest_packet = 64;  // four registers of sixteen floats
    if (options_.lanes.empty()) return kernel.form != Form::gang || kernel.lanes > longest_packet;
    return std::count(options_.lanes.begin(), options_.lanes.end(), kernel.lanes) > 0;
}

std::string words_for(const Plan& plan, const KernelInfo& kernel) {
    std::string text = std::string(plan.module().isa) + " " + name_of(kernel.strategy);
    if (kernel.form != Form::none) text += std::string(" ") + name_of(kernel.form);
    return text + " " + name_of(kernel.precision) + ", " + std::to_string(kernel.lanes) + " lanes";
}

void Comparer::check_lanes() const {
    std::set<std::uint32_t> known;
    for (const Plan& plan : plans_)
        for (std::uint32_t i = 0; i < plan.module().kernel_count; ++i) known.insert(plan.module().kernels[i].lanes);
    for (const std::uint32_t lanes : options_.lanes) {
        if (known.count(lanes)) continue;
        std::string text;
        for (const std::uint32_t n : known) enumerate(text, std::to_string(n));
        throw InputError("--lanes: no kernel has " + std::to_string(lanes) + "; lanes there are: " + text);
    }
}

/// Where nothing else was asked for than is there, somewhere.
void Comparer::check_wanted() const {
    for (const Plan& plan : plans_)
        for (std::uint32_t i = 0; i < plan.module().kernel_count; ++i)
            if (wanted(plan.module().kernels[i])) return;
    std::string asked;
    if (options_.strategy) enumerate(asked, std::string("strategy ") + name_of(*options_.strategy));
    if (options_.precision) enumerate(asked, name_of(*options_.precision));
    for (const std::uint32_t lanes : options_.lanes)
        enumerate(asked, std::to_string(lanes) + (lanes == 1 ? " lane" : " lanes"));
    throw InputError(asked + ": there is no such kernel; `kagero list strategies` shows those there are");
}

void Comparer::choose_rows() {
    check_lanes();
    check_wanted();
    if (options_.equal_error > 0) {
        const Candidates candidates = find_candidates(plans_.front(), options_.equal_error, stop_);
        for (const Plan& plan : plans_) choose_by_error(plan, candidates);
        return;
    }
    auto methods = options_.methods;
    if (methods.empty()) methods.push_back(plans_.front().method().name);
    for (const Plan& plan : plans_)
        for (const std::string& method : methods) choose_by_method(plan, method);
}

void Comparer::check_method(const Plan& plan, const std::string& method) const {
    std::vector<std::string> known;
    for (std::uint32_t i = 0; i < plan.module().integrator_count; ++i)
        known.push_back(plan.module().integrators[i].name);
    const auto place = std::find(known.begin(), known.end(), method);
    if (place == known.end())
        throw InputError("--methods: there is no integrator \"" + method + "\"" + suggestion(method, known));
    if (find_variant(plan, method, Strategy::scalar, Precision::float64, 0)) return;
    if (const char* why = refusal_of(*plan.scene, static_cast<std::uint32_t>(place - known.begin()), false))
        throw InputError("--methods: " + method + " cannot serve " + plan.description().space.hamiltonian + ": " + why);
}

/// The kernel that all others are measured by comes first.
std::vector<const KernelInfo*> yardstick_first(const Module& module) {
    std::vector<const KernelInfo*> kernels;
    for (std::uint32_t i = 0; i < module.kernel_count; ++i) kernels.push_back(&module.kernels[i]);
    std::stable_sort(kernels.begin(), kernels.end(), [](const KernelInfo* a, const KernelInfo* b) {
        const auto place = [](const KernelInfo& k) {
            return std::array{int(!is_yardstick(k)), int(k.strategy), int(k.precision), int(k.lanes)};
        };
        return place(*a) < place(*b);
    });
    return kernels;
}

void Comparer::choose_by_method(const Plan& plan, const std::string& method) {
    check_method(plan, method);
    std::size_t yardstick = runners_.size();
    for (const KernelInfo* kernel : yardstick_first(plan.module())) {
        if (!is_yardstick(*kernel) && !wanted(*kernel)) continue;
        auto variant = find_variant(plan, method, *kernel, 0);
        if (!variant) {
            const auto integrator =
                find_variant(plan, method, Strategy::scalar, Precision::float64, 0)->method.integrator;
            const char* why = refusal_of(*plan.scene, *kernel, {integrator, plan.run.method.rescaled});
            result_.left_out.push_back({words_for(plan, *kernel) + ", " + method, why ? why : "the method is refused"});
            continue;
        }
        const IntegratorDescription& scene = plan.description().integrator;
        variant->step = info_of(plan, *variant).adaptive ? plan.run.tolerance
                        : scene.step_place               ? kernel_step(plan, *variant, scene.step)
                                                         : usual_step(plan, *variant);
        add(plan, *variant, yardstick);
    }
}

void Comparer::choose_by_error(const Plan& plan, const Candidates& candidates) {
    std::size_t yardstick = runners_.size();
    for (const KernelInfo* kernel : yardstick_first(plan.module())) {
        if (stopped()) return;
        if (!is_yardstick(*kernel) && !wanted(*kernel)) continue;
        if (kernel->form == Form::gang && options_.lanes.empty()) {
            result_.left_out.push_back({words_for(plan, *kernel),
                                        "it takes the steps of its packets, and is searched for with --lanes alone"});
            continue;
        }
        const auto variant = cheapest_for(plan, *kernel, candidates, stop_);
        if (stopped()) return;
        if (variant) {
            add(plan, *variant, yardstick);
        } else if (is_yardstick(*kernel)) {
            throw RunError("--equal-error: no method in double precision comes so near");
        } else {
            result_.left_out.push_back({words_for(plan, *kernel), "no method that it serves comes so near"});
        }
    }
}

void Comparer::add(const Plan& plan, const Variant& variant, std::size_t& yardstick) {
    const KernelInfo& kernel = *variant.kernel;
    if (is_yardstick(kernel)) yardstick = runners_.size();
    Runner runner{{}, plan_by(plan, variant), yardstick, {}};
    CompareRow& row = runner.row;
    row.isa = plan.module().isa, row.kernel = &kernel, row.method = info_of(plan, variant).name;
    row.step = stated_step(plan, variant);
    row.solver_tolerance = variant.solver_tolerance >= 0 ? variant.solver_tolerance : plan.run.solver_tolerance;
    row.shape = shape_of(plan, kernel, false);
    runners_.push_back(runner);
    // Rows of the picture, as in the paper, for the packets taken unasked; a tile must hold them.
    constexpr std::uint32_t widest_run = 32;
    if (kernel.strategy != Strategy::packet || kernel.refusal || kernel.lanes > widest_run || !plan.job().camera)
        return;
    runner.plan.run.scanlines = true, row.shape = shape_of(plan, kernel, true);
    runners_.push_back(runner);
}

RunReport Comparer::draw(const Runner& runner, Film& film) const {
    return render_with_errors(runner.plan, film, {.stop = stop_});
}

/// Also warms up caches and clocks.
void Comparer::compare_pictures() {
    std::map<std::size_t, Film> films;
    for (std::size_t i = 0; i < runners_.size() && !stopped(); ++i) {
        Runner& runner = runners_[i];
        const FilmDescription& size = runner.plan.description().film;
        Film film(size.width, size.height, {"color", "status", "object"});
        const RunReport report = draw(runner, film);
        if (report.interrupted) return;
        runner.row.drawn = true;
        result_.rays = report.rays;
        const Counters& work = report.counters;
        if (work.issued_lane_steps)
            runner.row.occupancy = double(work.active_lane_steps) / double(work.issued_lane_steps);
        if (runner.yardstick == i) {
            films.clear();  // rows of one yardstick follow each other
            films.emplace(i, std::move(film));
            continue;
        }
        const Film& should = films.at(runner.yardstick);
        const auto at = [](const Film& f, const char* layer, std::size_t k) { return f.plane(layer)[k]; };
        for (std::size_t k = 0; k < std::size_t(size.width) * size.height; ++k) {
            const bool same =
                at(should, "status", k) == at(film, "status", k) && at(should, "object", k) == at(film, "object", k);
            if (!same) ++runner.row.flips;
            for (std::size_t c = 0; same && c < 3; ++c)
                runner.row.max_difference =
                    std::max(runner.row.max_difference,
                             double(std::abs(at(should, "color", 3 * k + c) - at(film, "color", 3 * k + c))));
        }
        tell(double(i + 1) / double(runners_.size() * (options_.rounds + 1)));
    }
}

void Comparer::take_times(unsigned round) {
    const double all = double(runners_.size() * (options_.rounds + 1));
    for (std::size_t i = 0; i < runners_.size(); ++i) {
        const FilmDescription& film = runners_[i].plan.description().film;
        Film picture(film.width, film.height, film.layers);
        const RunReport report = draw(runners_[i], picture);
        if (stopped()) return;
        runners_[i].seconds.push_back(report.seconds);
        tell(double(runners_.size() * (round + 1) + i + 1) / all);
    }
    ++result_.rounds;
}

void Comparer::finish(Runner& runner) {
    const auto& yardstick = runners_[runner.yardstick].seconds;
    runner.seconds.resize(result_.rounds);  // of a round that was interrupted nothing counts
    std::vector<double> ratios;
    for (unsigned round = 0; round < result_.rounds; ++round)
        ratios.push_back(yardstick[round] / runner.seconds[round]);
    runner.row.speedup = timing_of(ratios).median;
    runner.row.seconds = timing_of(runner.seconds);
    runner.row.rays_per_second = double(result_.rays) / runner.row.seconds.median;
    result_.rows.push_back(runner.row);
}

}  // namespace

Comparison compare(const SceneDescription& scene, const CompareOptions& options, const Progress& progress,
                   const std::atomic<bool>* stop) {
    return Comparer(scene, options, progress, stop).run();
}

}  // namespace kagero
