"""Made the worlds of this folder, which do not change any more; kept to show where they come from.

    python make.py PROGRAM MAPS FOLDER

PROGRAM: cocarry. MAPS: the folder nav2_bringup/maps of ros-navigation/navigation2 at a3a97043 (Apache-2.0); the outlines
of depot and warehouse are from there. Worlds are drawn until people of the paper's ranges disagree (no option has more than
90 %), and every robot arrives with two humans who lead.
"""

import json
import math
import random
import subprocess
import sys
from pathlib import Path

PROGRAM, MAPS, FOLDER = (Path(argument).resolve() for argument in sys.argv[1:])
ROBOTS = Path(__file__).resolve().parent.parent / "robots"
MOST = 0.9
TRIES = 400


def box(name, x, y, width, depth, yaw=0.0, height=2.0):
    turned = f"yaw_deg = {yaw:.1f}\n" if yaw else ""
    return (
        f'\n[[obstacle]]\nname = "{name}"\nshape = "box"\ncenter_m = [{x:.3f}, {y:.3f}]\n'
        f"size_m = [{width:.3f}, {depth:.3f}]\n{turned}height_m = {height}\n"
    )


def post(name, x, y, radius, height=2.0):
    return (
        f'\n[[obstacle]]\nname = "{name}"\nshape = "cylinder"\ncenter_m = [{x:.3f}, {y:.3f}]\n'
        f"radius_m = {radius:.3f}\nheight_m = {height}\n"
    )


def world(name, note, start, target, obstacles):
    head = f'name = "{name}"\nnote = "{note}"\nrobot_width_m = 0.5\n'
    head += f"start_m = [{start[0]:.3f}, {start[1]:.3f}]\ntarget_m = [{target[0]:.3f}, {target[1]:.3f}]\n"
    return head + "".join(obstacles)


def room(west, east, south, north):
    """Four walls, 0.2 m thick, around a floor."""
    x, y, width, depth = (west + east) / 2, (south + north) / 2, east - west, north - south
    return [
        box("south", x, south - 0.1, width + 0.4, 0.2),
        box("north", x, north + 0.1, width + 0.4, 0.2),
        box("west", west - 0.1, y, 0.2, depth),
        box("east", east + 0.1, y, 0.2, depth),
    ]


def wall(name, x, south, north, gaps, thickness=0.2):
    """A wall across, with gaps (middle, width)."""
    pieces, low = [], south
    for middle, width in [*sorted(gaps), (north + 0.5, 1.0)]:
        high = middle - width / 2
        pieces.append(box(f"{name}-{len(pieces) + 1}", x, (low + high) / 2, thickness, high - low))
        low = middle + width / 2
    return pieces


def gaps(draw, south, north, count):
    """Gaps that leave at least a metre of wall between them."""
    while True:
        found = [(draw.uniform(south + 1, north - 1), draw.uniform(0.9, 1.9)) for _ in range(count)]
        found.sort()
        edges = [(middle - width / 2, middle + width / 2) for middle, width in found]
        if edges[0][0] > south + 0.4 and edges[-1][1] < north - 0.4:
            if all(after[0] - before[1] > 1.0 for before, after in zip(edges, edges[1:])):
                return found


def walls(draw, name):
    count = draw.choice([1, 2, 2, 3])
    xs = [3.5 + 3.5 * i for i in range(count)]
    depth, east = draw.uniform(7, 11), 3.5 + 3.5 * count + 1.5
    obstacles = room(-3.0, east + 1.5, 0.0, depth)
    for i, x in enumerate(xs):
        obstacles += wall(f"wall-{i + 1}", x, 0.0, depth, gaps(draw, 0.0, depth, draw.choice([2, 2, 3])))
    start, target = (0.0, draw.uniform(1.5, depth - 1.5)), (east - 1.0, draw.uniform(1.5, depth - 1.5))
    return world(name, "Walls across a room, with openings at random places.", start, target, obstacles)


def posts(draw, name):
    width = draw.uniform(2.8, 3.8)
    obstacles = room(-3.5, 12.0, -width / 2, width / 2)
    for i in range(draw.choice([1, 2])):
        radius = draw.uniform(0.12, 0.25)
        obstacles.append(post(f"post-{i + 1}", 3.0 + 3.5 * i, draw.uniform(-0.45, 0.45) * (width - 2.4), radius))
    return world(name, "A corridor with posts.", (0.0, 0.0), (9.0, 0.0), obstacles)


def slots(draw, name):
    depth = draw.uniform(7, 9)
    obstacles = room(-3.0, 13.0, 0.0, depth)
    length, x = draw.uniform(1.0, 3.0), draw.uniform(4.0, 5.0)
    openings = gaps(draw, 0.0, depth, draw.choice([2, 3]))
    obstacles += wall("block", x, 0.0, depth, openings, length)
    start, target = (0.0, draw.uniform(1.5, depth - 1.5)), (10.0, draw.uniform(1.5, depth - 1.5))
    return world(name, "Slots between long blocks.", start, target, obstacles)


def clutter(draw, name):
    depth = draw.uniform(6.5, 9)
    obstacles, discs = room(-3.0, 14.0, 0.0, depth), []
    for i in range(draw.randint(6, 10)):
        for _ in range(200):
            x, y, radius = draw.uniform(2.5, 8.5), draw.uniform(0.3, depth - 0.3), draw.uniform(0.15, 0.75)
            off = min([math.dist((x, y), disc[:2]) - disc[2] for disc in discs] + [y, depth - y]) - radius
            if off > 0.95:
                discs.append((x, y, radius))
                if draw.random() < 0.5:
                    obstacles.append(post(f"drum-{i + 1}", x, y, radius, 1.1))
                else:
                    angle, turn = draw.uniform(25, 65), draw.uniform(0, 180)
                    width, across = (2 * radius * f(math.radians(angle)) for f in (math.cos, math.sin))
                    obstacles.append(box(f"crate-{i + 1}", x, y, width, across, turn, 1.1))
                break
    start, target = (0.0, draw.uniform(1.5, depth - 1.5)), (11.0, draw.uniform(1.5, depth - 1.5))
    return world(name, "Drums and crates on a floor.", start, target, obstacles)


def doors(draw, name):
    depth = draw.uniform(8, 10)
    middle = draw.uniform(0.4, 0.6) * depth
    obstacles = room(-3.0, 14.0, 0.0, depth)
    for i, x in enumerate((3.0, 8.0)):
        low, high = draw.uniform(1.0, middle - 1.2), draw.uniform(middle + 1.2, depth - 1.0)
        obstacles += wall(f"wall-{i + 1}", x, 0.0, depth, [(low, draw.uniform(0.9, 1.3)), (high, draw.uniform(0.9, 1.3))])
    door, width = draw.uniform(4.4, 6.6), draw.uniform(1.0, 1.4)
    for i, (low, high) in enumerate(((3.1, door - width / 2), (door + width / 2, 7.9))):
        obstacles.append(box(f"partition-{i + 1}", (low + high) / 2, middle, high - low, 0.2))
    start, target = (0.0, draw.uniform(2, depth - 2)), (11.0, draw.uniform(2, depth - 2))
    return world(name, "Two rooms side by side with a door between them.", start, target, obstacles)


def twins(draw, name):
    depth, off, width = draw.uniform(7, 9), draw.uniform(1.6, 2.4), draw.uniform(0.95, 1.4)
    obstacles = room(-3.0, 12.0, -depth / 2, depth / 2)
    obstacles += wall("wall", 4.5, -depth / 2, depth / 2, [(-off, width), (off, width)])
    return world(name, "Two openings alike: nobody can know which one a person prefers.", (0.0, 0.0), (9.0, 0.0), obstacles)


def places(image, x, y):
    """Draws a start and a target on the free floor of a map."""

    def make(draw, name):
        start, target = ((draw.uniform(*x), draw.uniform(*y)) for _ in range(2))
        if not 8 < math.dist(start, target) < 16:
            return None
        written = FOLDER / f"{name}.map.toml"
        written.unlink(missing_ok=True)
        at = [f"{a:.2f},{b:.2f}" for a, b in (start, target)]
        command = [PROGRAM, "world", MAPS / image, "--start", at[0], "--target", at[1], "--write", written]
        if subprocess.run(command, capture_output=True).returncode:
            return None
        text = written.read_text()
        written.unlink()
        image_name = Path(image).stem
        named = f'name = "{name}"\nnote = "Floor of the map {image_name} of nav2_bringup (Apache-2.0), traced."\n'
        kept = [line for line in text.splitlines() if not line.startswith(("#", "name ="))]
        return named + "\n".join(kept).replace("\n\n\n", "\n\n") + "\n"

    return make


def run(file, *arguments):
    command = [PROGRAM, "run", file, "--plant", "rapier", "--json", *arguments]
    done = subprocess.run(command, capture_output=True, text=True)
    return json.loads(done.stdout).get("outcome") if done.stdout.startswith("{") else None


def suits(file):
    told = subprocess.run([PROGRAM, "world", file, "--json"], capture_output=True, text=True)
    if told.returncode:
        return False
    options = json.loads(told.stdout)["options"]
    if len(options) < 2 or max(option["probability"] or 0 for option in options) > MOST:
        return False
    robots = [[], *(["--robot", ROBOTS / f"{name}.toml"] for name in ("omni-carrier", "porter"))]
    return all(
        run(file, "--method", "human-led", "--seed", str(seed), *robot) == "arrived" for robot in robots for seed in (1, 2)
    )


FAMILIES = [
    (walls, "walls", 6),
    (posts, "posts", 3),
    (slots, "slots", 3),
    (clutter, "clutter", 4),
    (doors, "doors", 3),
    (twins, "twins", 1),
    (places("depot.yaml", (2, 28), (2, 13)), "depot", 2),
    (places("warehouse.yaml", (-13, 13), (-23, 23)), "warehouse", 3),
]

for make, family, count in FAMILIES:
    found, tried = 0, 0
    draw = random.Random(family)
    while found < count and tried < TRIES:
        name = f"{family}-{found + 1}"
        tried += 1
        text = make(draw, name)
        if text is None:
            continue
        file = FOLDER / f"{name}.toml"
        file.write_text(text)
        if suits(file):
            found += 1
            print(f"{name}: {tried} tried", flush=True)
        else:
            file.unlink()
