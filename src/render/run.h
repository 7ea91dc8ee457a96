/// Tiles over threads: the one place where work is shared out.
#pragma once

#include "render/render.h"

#include <functional>
#include <vector>

namespace kagero {

/// Takes the finished rays of one tile; called from several threads at once, for different tiles.
using TileDone = std::function<void(const Tile&, const RayEnd*)>;

RunReport run_tiles(const Plan& plan, const Job& job, const std::vector<Tile>& tiles, const TileDone& done,
                    const Progress& progress = {}, const std::atomic<bool>* stop = nullptr);

}  // namespace kagero
