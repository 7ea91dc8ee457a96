// Fuzz target for the reader of scenes: any text must be read as a scene or refused by an InputError. A scene that is
// printed and read again must be printed as the same text. The files of textures and meshes are not opened.
#include "error.h"
#include "plan/scene.h"
#include "scene/load/load.h"
#include "scene/print.h"
#include "target.h"

#include <string>

const char* const fuzz_words =
    "[space] [integrator] [camera] [film] [sky] [sky.far] [[object]] [object.faces] [space.constants] [space.let] "
    "[[medium]] [medium.integrator] [medium.constants] [medium.let] material interior exterior fresnel tint medium "
    "max_bounces uniform mirror boundary surface transmit auto none glass = [ "
    "] { } , # \" ''' "
    "hamiltonian rg center spin mass throat seed method step tolerance solver_tolerance max_steps escape_radius hit "
    "cull rescale refill "
    "lanes max_pixel_error type position look_at up fov height observer size spp layers color texture checker pole "
    "name shape origin "
    "edge_u edge_v min max faces px nx py ny pz nz center radius normal inner outer temperature file translate rotate "
    "scale shading "
    "formula schwarzschild kerr wormhole mirage shimmer fisheye luneburg fiber layer flat gauss8 verlet dp54 satoh4 "
    "perspective static "
    "orthographic equirectangular rectangle box room sphere mesh disk true false nan inf -inf 1e400 -0.0 0x10 1_000 "
    "1979-05-27 x y z";

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace kagero;
    const std::string text(reinterpret_cast<const char*>(data), size);
    static const Catalogue names = catalogue("auto");
    try {
        const std::string printed = print_scene(load_scene_text(text, "scene", {}, names));
        if (print_scene(load_scene_text(printed, "printed", {}, names)) != printed) __builtin_trap();
        return 0;
    } catch (const InputError&) {
        return -1;
    }
}
