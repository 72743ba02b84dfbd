"""The book's pages of robots, from what check.py has found: figures, robot files, pictures."""

import collections
import pathlib
import re
import subprocess
import tomllib

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
BOOK = REPOSITORY / "book/src"
FOLDER = BOOK / "gallery"
# Where the table and the count stand in gallery.md
BEGIN, END = "<!-- written by tests/gallery/check --pages -->", "<!-- end -->"
# Title, base if not the robot's own, and what is particular
TITLES = {
    "tiago": ("TIAGo", None, ""),
    "tiago_no_hand": ("TIAGo without a hand", None, ""),
    "tiago_dual": ("TIAGo dual, left arm", None, "The right arm is idle: it is tucked away under `[hold]`."),
    "tiago_pro": ("TIAGo Pro, left arm", None, "The right arm is idle: it is tucked away under `[hold]`. The limits of the base are assumed."),
    "pr2": ("PR2, left arm", None, "The right arm is idle: it is tucked away under `[hold]`. The limits of the base are assumed."),
    "panda": ("Panda", "the test's, differential", ""),
    "ur3": ("UR3", "the test's, differential", ""),
    "ur5": ("UR5", "the test's, differential", ""),
    "ur10": ("UR10", "the test's, differential", ""),
    "kinova": ("Kinova", "the test's, differential", ""),
    "xarm7": ("xArm7", "the test's, differential", ""),
    "z1": ("Z1", "the test's, differential", ""),
    "ur5_omni": ("UR5 on mecanum wheels", "the test's, mecanum", ""),
    "ur10_omni": ("UR10 on mecanum wheels", "the test's, mecanum", ""),
    "kinova_omni": ("Kinova on mecanum wheels", "the test's, mecanum", ""),
    "panda_omni": ("Panda on mecanum wheels", "the test's, mecanum", ""),
    "xarm7_omni": ("xArm7 on mecanum wheels", "the test's, mecanum", ""),
    "porter": ("Porter", None, "A round base on two wheels, a lift on a column, and an arm with a roll joint in its forearm."),
    "shuttle": ("Shuttle", None, "Four mecanum wheels, a pedestal, and an arm whose upper and lower halves lie side by side."),
}
OWN = ["porter", "shuttle"]
# Robots of repositories
TABLE = tomllib.loads((pathlib.Path(__file__).parent / "repositories.toml").read_text())
TITLES |= {name: (entry["title"], None, entry.get("about", "")) for name, entry in TABLE["robot"].items()}
PLANTS = {"kinematic": "kinematic", "rapier": "physical"}


def package_of(told: dict, robots: pathlib.Path) -> pathlib.Path:
    """The folder of a robot's description: of an arm on a base of the test's, that of the arm's meshes."""
    try:
        return robots / told["urdf"].relative_to(robots).parts[0]
    except ValueError:
        found = re.search(r"package://example-robot-data/robots/(\w+)/", told["urdf"].read_text())
        return robots / found[1]


def terms(package: pathlib.Path) -> tuple[str, str]:
    """Source and licence by the package's readme."""
    readme = (package / "README.md").read_text()
    found = lambda key: re.search(rf"(?mi)^{key}: *(\S.*)$", readme)[1].strip()
    return found("upstream"), found("license")


def has_picture(name: str, told: dict) -> bool:
    """Whether nobody forbids changed versions of a robot's description, or pictures that are sold, and its repository has
    its meshes."""
    if name in TABLE["robot"]:
        entry = TABLE["robot"][name]
        licence = TABLE["repository"][entry["repository"]]["licence"]
        return entry.get("pictured", True) and not re.search("NC|ND", licence)
    return name in OWN or name in TITLES and not re.search("NoDeriv|NonCommercial", told["urdf"].read_text())


def pictures(all_told: dict[str, dict], cocarry, work: pathlib.Path) -> None:
    """Writes the pictures of robots whose descriptions allow it."""
    (FOLDER / "pictures").mkdir(parents=True, exist_ok=True)
    viewer = REPOSITORY / "viewer"
    if not (viewer / "node_modules").exists():
        subprocess.run(["npm", "ci", "--silent", "--no-fund", "--no-audit"], cwd=viewer, check=True)
    names = []
    for name, told in all_told.items():
        if not has_picture(name, told):
            continue
        page = work / f"{name}.html"
        said = cocarry("robot", "check", told["file"], "--render", page)
        if said.returncode != 0:
            raise SystemExit(f"{name}: {said.stderr}")
        names += [page, FOLDER / "pictures" / f"{file_of(name)}.webp"]
    subprocess.run(["node", REPOSITORY / "tests/gallery/picture.mjs", *names], check=True)


def file_of(name: str) -> str:
    return name.replace("_", "-")


def robot_file(name: str, told: dict, robots: pathlib.Path) -> str:
    """The robot file, with the URDF as it is named in its package."""
    if name in TABLE["robot"]:
        urdf = TABLE["robot"][name]["urdf"]
    else:
        try:
            urdf = told["urdf"].relative_to(robots).as_posix()
        except ValueError:
            urdf = told["urdf"].name
    return re.sub(r'(?m)^urdf = .*$', f'urdf = "{urdf}"', told["file"].read_text()).strip()


def drive_words(drive: dict) -> str:
    if drive["kind"] == "omnidirectional":
        return f"omnidirectional, up to {drive['speed_limit_m_s']:.2f} m/s along x and y, and {drive['turn_limit_rad_s']:.2f} rad/s"
    return f"{drive['kind']}, wheels of {drive['wheel_radius_m']:.3f} m radius, up to {drive['speed_limit_m_s']:.2f} m/s"


def page(name: str, told: dict, robots: pathlib.Path, seeds: int) -> str:
    title, base, about = TITLES[name]
    checked, rows = told["checked"], told["rows"]
    posture = checked["postures"][0]
    is_own = name in OWN
    lines = [f"# {title}", ""]
    if has_picture(name, told):
        lines += [f"![{title} in its first posture](pictures/{file_of(name)}.webp)", ""]
    if is_own:
        # the page that runs the simulator has these
        lines += [f"[Run it in the page](../page.md#robot={name})", ""]
    if about:
        lines += [about, ""]
    if base:
        kind = "two wheels" if "differential" in base else "four mecanum wheels"
        lines += [f"The test puts the arm on a round base with {kind}.", ""]
    if is_own:
        lines += [
            f"It is a design of this project, under its licence; `assets/robots/make.py` writes its URDF and its meshes, and `cocarry export {name}`",
            "gives all its files:", "",
            "```sh", f"cocarry export {name}", f"cocarry robot check {name}.toml --render {name}.html",
            f"cocarry run environment-1 --robot {name}.toml --seed 1", "```", "",
        ]
    elif name in TABLE["robot"]:
        repository = TABLE["robot"][name]["repository"]
        pinned = TABLE["repository"][repository]
        lines += [f"Description: <https://github.com/{repository}>, commit {pinned['commit'][:12]}. Licence: {pinned['licence']}."]
        if not has_picture(name, told):
            lines += ["There is no picture of its meshes here; `cocarry robot check robot.toml --render robot.html` shows it, where the repository is at hand."]
        lines += [""]
    else:
        upstream, licence = terms(package_of(told, robots))
        lines += [f"Description: <{upstream}>, as in `example-robot-data` 6.0.0. Licence, by its readme: {licence}.", ""]
        if not has_picture(name, told):
            lines += [
                "The URDF itself names CC BY-NC-ND 3.0. So there is no picture of its meshes here;",
                "`cocarry robot check robot.toml --render robot.html` shows it, where the package is installed.", "",
            ]
    room = f"nearest to a limit: `{posture['tightest_joint']}`, {100 * posture['room']:.0f} % of half its range away" if posture["room"] is not None else "no limits"
    lines += [
        "| what | value |", "| --- | --- |",
        f"| drive | {drive_words(checked['drive'])} |",
        f"| base | {checked['base']['width_m']:.2f} m wide, {checked['base']['mass_kg']:.1f} kg; it needs openings of {posture['needed_width_m']:.2f} m |",
        f"| arm | {len(checked['joints'])} joints, {checked['arm_mass_kg']:.1f} kg |",
        f"| grasp | `{tomllib.loads(told['file'].read_text())['grasp_frame']}`, held at {checked['grasp_height_m']:g} m |",
        f"| first posture | the grasp {posture['ahead_m']:.2f} m ahead; it reaches from {posture['nearest_m']:.2f} to {posture['farthest_m']:.2f} m; {room} |",
        f"| payload | {payload_words(posture, told['object_kg'])} |",
        f"| postures | {', '.join(p['name'] for p in checked['postures'])} |",
        "",
        "| joint | from | to | rate |", "| --- | --- | --- | --- |",
    ]
    for joint in checked["joints"]:
        scale, unit, digits = (57.29577951308232, "°", 0) if joint["motion"] == "revolute" else (1.0, " m", 2)
        at = lambda value: "free" if value is None else f"{round(value * scale, digits) + 0.0:.{digits}f}{unit}"
        rate = f"{joint['rate_limit'] * scale:.{2 if digits else 0}f}{unit}/s"
        lines.append(f"| `{joint['name']}` | {at(joint['lower'])} | {at(joint['upper'])} | {rate} |")
    lines += ["", "## How it carries", "", "Episodes that arrived:", ""]
    worlds = sorted({row["world"] for row in rows})
    lines += ["| plant | " + " | ".join(re.sub(r".*environment-(\d).*", r"environment \1", world) for world in worlds) + " |"]
    lines += ["| --- " * (len(worlds) + 1) + "|"]
    for plant, words in PLANTS.items():
        cells = []
        for world in worlds:
            of = [row for row in rows if (row["plant"], row["world"]) == (plant, world)]
            cells.append(f"{sum(row['outcome'] == 'arrived' for row in of)} of {len(of)}")
        lines.append(f"| {words} | " + " | ".join(cells) + " |")
    width = posture["needed_width_m"]
    scaled = f", in worlds scaled by {width / 0.5:.2f} for the width that it needs" if width > 0.5 else ""
    lines += [
        "", f"{told['arrived']} of {len(rows)} arrived{scaled}; {seeds} seeds each. The grasp error is at most {1000 * told['error_m']:.1f} mm (rms) in those that arrived.",
    ]
    others = [f"{count} {outcome} ({PLANTS[plant]} plant)" for (plant, outcome), count in told["others"].items()]
    if others:
        lines += [f"The others: {', '.join(others)}. [All robots](../gallery.md) says why."]
    said = "It is in `assets/robots`." if is_own else (
        f"`cocarry robot init{''.join(' ' + word for word in told['arguments'])}` drafts it from the URDF"
        + (", with `--hold` for the joints of the idle arm." if "right arm" in about else ".")
    )
    lines += [
        "", "## Robot file", "", said, "",
        f"<details><summary>{'The' if is_own else 'The drafted'} robot file</summary>", "", "```text", robot_file(name, told, robots), "```", "", "</details>", "",
    ]
    return "\n".join(lines)


def payload_words(posture: dict, mass: float) -> str:
    """What the arm holds at rest, by J^T F, and the object that it carries here."""
    held = posture["holds_kg"]
    if held is None:
        return f"no joint has an effort limit; here an object of {mass:.1f} kg"
    return f"holds {held:.1f} kg at the grasp, where `{posture['weakest_joint']}` is at its effort limit; here an object of {mass:.1f} kg"


def table(all_told: dict[str, dict]) -> list[str]:
    lines = ["| robot | base | joints | width (m) | object (kg) | arrived | grasp error (mm) | otherwise |", "| --- | --- | --- | --- | --- | --- | --- | --- |"]
    for name, told in all_told.items():
        title, base, _ = TITLES[name]
        checked = told["checked"]
        others = ", ".join(f"{count} {outcome} ({plant})" for (plant, outcome), count in told["others"].items())
        lines.append(
            f"| [{title}](gallery/{file_of(name)}.md) | {base or checked['drive']['kind']} | {len(checked['joints'])} | {checked['postures'][0]['needed_width_m']:.2f} "
            f"| {told['object_kg']:.1f} | {told['arrived']} of {len(told['rows'])} | {1000 * told['error_m']:.1f} | {others or '-'} |"
        )
    return lines


def write(all_told: dict[str, dict], robots: pathlib.Path, seeds: int, is_all: bool) -> None:
    """Writes the pages; with all robots, the table of gallery.md too."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name, told in all_told.items():
        (FOLDER / f"{file_of(name)}.md").write_text(page(name, told, robots, seeds))
    if not is_all:
        return
    counts = collections.Counter()
    for told in all_told.values():
        is_above = told["arrived"] >= 0.95 * len(told["rows"]) and told["error_m"] < 0.03
        counts.update({"all": 1, "above": is_above, "arrived": told["arrived"], "episodes": len(told["rows"])})
    lines = [
        *table(all_told), "",
        f"{counts['above']} of {counts['all']} are above the bar; {counts['arrived']} of {counts['episodes']} episodes arrived.",
    ]
    file = BOOK / "gallery.md"
    before, rest = file.read_text().split(BEGIN)
    after = rest.split(END)[1]
    file.write_text(before + BEGIN + "\n\n" + "\n".join(lines) + "\n\n" + END + after)
