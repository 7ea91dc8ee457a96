#include "view/tabs.h"

#include <algorithm>

namespace kagero {

void Tab::cancel() {
    const std::lock_guard lock(running_mutex);
    if (running) *running = true;
}

std::shared_ptr<Tab> Tabs::find(const std::string& name, std::chrono::steady_clock::time_point now) {
    const std::lock_guard lock(mutex_);
    auto found = tabs_.find(name);
    if (found == tabs_.end()) {
        if (tabs_.size() >= max_tabs) {
            const auto oldest = std::min_element(tabs_.begin(), tabs_.end(), [](const auto& a, const auto& b) {
                return a.second->last_used < b.second->last_used;
            });
            if (now - oldest->second->last_used < idle_time) return nullptr;
            oldest->second->cancel();
            tabs_.erase(oldest);
        }
        found = tabs_.emplace(name, std::make_shared<Tab>(scene_)).first;
    }
    found->second->last_used = now;
    return found->second;
}

void Tabs::cancel_all() {
    const std::lock_guard lock(mutex_);
    for (const auto& [name, tab] : tabs_) tab->cancel();
}

}  // namespace kagero
