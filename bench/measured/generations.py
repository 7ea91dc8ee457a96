"""Claims about rays that continue: cost and occupancy of their generations."""
import statistics

from .claim import ROOM, Claim
from .program import SCENES

# The room with mirrors as walls and a lamp.
MIRROR_ROOM = '''[space]
hamiltonian = "schwarzschild"
rg = 0.08
[integrator]
escape_radius = 4
[camera]
position = [0.22, -0.92, 0.16]
look_at = [0, 0, 0]
up = [0, 0, 1]
fov = 96
[film]
size = [512, 512]
max_bounces = 4
[[object]]
shape = "room"
min = [-1, -1, -1]
max = [1, 1, 1]
material = "mirror"
[[object]]
shape = "sphere"
center = [0.5, 0.4, -0.6]
radius = 0.2
'''


# A square outside the walls of the room.
UNSEEN_SQUARE = '''
[[object]]
name = "unseen"
shape = "rectangle"
origin = [1.5, -1, -1]
edge_u = [0, 2, 0]
edge_v = [0, 0, 2]
'''


def bounces(program, _):
    """Cost of the generations of rays in a room of mirrors, of those in the same room with diffuse walls, and cost of
    following paths where no ray meets a mirror. A scene without mirrors and boundaries does not follow paths;
    `tests/corpus OLD NEW` compares such scenes. The times of generations are processor times, from `generations` in the
    JSON of `kagero render mirror-room.toml --threads 1 --json` with the scene MIRROR_ROOM above."""
    scene = program.directory / "mirror-room.toml"
    scene.write_text(MIRROR_ROOM)
    costs, occupancies = [], []
    for _ in range(program.rounds):
        generations = program.render(scene, "--threads", 1)[0]["generations"]
        costs.append(max(g["ns_per_ray"] for g in generations[1:]) / generations[0]["ns_per_ray"])
        occupancies.append(min(100 * g["lane_occupancy"] for g in generations if g["rays"] > 1e4))
    diffuse = program.directory / "diffuse-room.toml"
    diffuse.write_text(MIRROR_ROOM.replace('"mirror"', '"diffuse"'))
    def segment_time(path):
        generations = program.render(path, "--threads", 1)[0]["generations"][1:]
        return sum(g["ns_per_ray"] * g["rays"] for g in generations) / sum(g["rays"] for g in generations)
    scattered = [segment_time(diffuse) / segment_time(scene) for _ in range(program.rounds)]
    def room_with(material):
        unseen = program.directory / f"unseen-{material}.toml"
        unseen.write_text((SCENES / ROOM).read_text() + UNSEEN_SQUARE + f'material = "{material}"\n')
        return program.render(unseen, "--threads", 1)[0]["seconds"]
    unseen = program.ratio(lambda: room_with("mirror"), lambda: room_with("surface"))
    return [Claim("bounces", "time per ray segment, room of mirrors: costliest of generations 1 to 4 ÷ generation 0",
                  [1.3], [1], [statistics.median(costs)], f"{min(costs):.2f} to {max(costs):.2f}", False),
            Claim("scattered", "time per path segment, diffuse walls ÷ mirrors, generations 1 to 4", [1.5], [1],
                  [statistics.median(scattered)], f"{min(scattered):.2f} to {max(scattered):.2f}", False),
            Claim("bounce-occupancy", "lane occupancy of the emptiest generation there, in percent", [90], [95],
                  [statistics.median(occupancies)], form="{:.0f}"),
            Claim("unseen-mirror", "room with a mirror that no ray meets ÷ with a plain square instead", [], [1.02],
                  [unseen.median], str(unseen), False)]


ALL = (bounces,)
