#include "cli/ranks/work_for_root.h"

#include "cli/interrupt.h"
#include "cli/verb.h"
#include "parts/choices.h"
#include "parts/identity.h"
#include "ranks/agreement.h"
#include "ranks/gather_frames.h"
#include "ranks/gather_tiles.h"
#include "ranks/shared_scene.h"
#include "ranks/shared_tiles.h"

namespace kagero {
namespace {

void render_tiles_for_root(const SceneDescription& scene, Options options, double time_limit, Communicator& ranks) {
    options.energy_error = true;
    Plan plan = make_plan(scene, options);
    const std::unique_ptr<ReceivedTiles> received = receive_tiles(ranks, identity_of(plan, options));
    plan = with_choices(std::move(plan), received->header.choices, "the message of rank 0");
    Film film = received->header.film(Planes::none);
    const InterruptGuard interrupts;
    agree(ranks);
    RunControl control;
    control.stop = InterruptGuard::requested();
    control.time_limit = time_limit;
    render_on_ranks(ranks, plan, received->header, film, received->finished, nullptr, control);
}

void render_frames_for_root(const SceneDescription& scene, Options options, double time_limit, Communicator& ranks) {
    options.energy_error = true;
    FramePlans plans(scene, options, {});
    const InterruptGuard interrupts;
    const std::vector<std::uint32_t> frames = share_frames(ranks, plans, options, {});
    FrameControl control;
    control.stop = InterruptGuard::requested();
    control.time_limit = time_limit;
    control.in_flight = frames_in_flight(plans.first());
    render_frames_on_ranks(ranks, plans, frames, control, {});
}

}  // namespace

int work_for_root(const Arguments& arguments, Options options, double time_limit, Communicator& ranks) {
    const ReceivedScene received(ranks);
    const SceneDescription scene = scene_of_text(arguments, options, received.text(), received.path());
    received.check_paths(scene);
    if (arguments.frames.empty()) render_tiles_for_root(scene, options, time_limit, ranks);
    else render_frames_for_root(scene, options, time_limit, ranks);
    return exit_done;
}

}  // namespace kagero
