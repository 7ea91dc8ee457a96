/// The pages that are open.
#pragma once

#include "view/picture_maker.h"

#include <chrono>
#include <map>
#include <mutex>

namespace kagero {

/// An open page.
struct Tab {
    explicit Tab(const ViewScene& scene) : maker(scene) {}

    std::mutex making;  ///< Held while `maker` works.
    PictureMaker maker;
    std::atomic<std::uint64_t> newest{0};  ///< Number of the last request for a picture.
    std::mutex running_mutex;
    std::shared_ptr<std::atomic<bool>> running;  ///< Cancels the whole picture that is being made; null if none is.
    std::chrono::steady_clock::time_point last_used;  ///< Protected by the mutex of Tabs.

    /// Cancels the whole picture that is being made, if there is one.
    void cancel();
};

/// Keeps a bounded number of pages. A page that sends no requests for a while is forgotten when another one needs its
/// place; it is made again when it sends a request.
class Tabs {
public:
    static constexpr std::size_t max_tabs = 6;
    static constexpr std::chrono::seconds idle_time{20};

    explicit Tabs(const ViewScene& scene) : scene_(scene) {}
    /// Returns the page with this name; null if too many pages are in use.
    std::shared_ptr<Tab> find(const std::string& name, std::chrono::steady_clock::time_point now);
    void cancel_all();

private:
    const ViewScene& scene_;
    std::mutex mutex_;
    std::map<std::string, std::shared_ptr<Tab>> tabs_;
};

}  // namespace kagero
