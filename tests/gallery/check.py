"""Published robots of `example-robot-data`: drafted, compared with pinocchio, and carrying on both plants.

    python check.py PROGRAM FOLDER [--repositories FOLDER] [--seeds N] [--only NAME ...] [--pages] [--pictures]

PROGRAM is `cocarry`, FOLDER the data's `robots`. Arms without a base stand on a differential base made here.
The project's own robots with meshes are compared and carry too, and robots of repositories (repositories.toml), where
there is a folder with a clone of each; those that are not there, or whose files differ, are skipped with a word. `--pages` writes the book's pages of the robots.
`--pictures` writes their pictures; alone, it compares nothing and no robot carries. Exits with 1 if anything differs from what is expected.
"""

import argparse
import collections
import csv
import hashlib
import json
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import tomllib
import xml.etree.ElementTree as ET

import cbor2
import coal
import motors
import numpy
import pages
import pinocchio
import scipy.spatial

# URDF, and the arguments of `robot init`
MOBILE = {
    "tiago": ("tiago_description/robots/tiago.urdf", []),
    "tiago_no_hand": ("tiago_description/robots/tiago_no_hand.urdf", []),
    "tiago_dual": ("tiago_description/robots/tiago_dual.urdf", ["--tool", "hand_left_grasping_frame"]),
    "tiago_pro": ("tiago_pro_description/robots/tiago_pro.urdf", ["--drive", "omnidirectional"]),
    "pr2": ("pr2_description/urdf/pr2.urdf", ["--drive", "omnidirectional", "--tool", "l_gripper_tool_frame"]),
}
# The arm that does not carry, tucked away within 0.3 m of the base's middle (rad)
TUCKED = {
    "tiago_dual": ("arm_right_{}_joint", [1.57, -1.178, -0.03, 0.737, -1.844, 1.268, 0.916]),
    "tiago_pro": ("arm_right_{}_joint", [-3.0, 1.134, -0.625, -2.443, 0.182, -0.57, -0.422]),
}
HOLD = {
    name: {joint.format(i): at for i, at in enumerate(angles, start=1)} for name, (joint, angles) in TUCKED.items()
} | {
    "pr2": {
        "r_shoulder_pan_joint": -0.024, "r_shoulder_lift_joint": 1.107, "r_upper_arm_roll_joint": -1.557,
        "r_elbow_flex_joint": -2.12, "r_forearm_roll_joint": -1.418, "r_wrist_flex_joint": -1.842,
        "r_wrist_roll_joint": 0.214,
    },
}
# URDF, where its root is on the base (m), and the arguments of `robot init`
ARMS = {
    "panda": ("panda_description/urdf/panda.urdf", [0.1, 0, 0.4], ["--tool", "panda_hand_tcp"]),
    "ur3": ("ur_description/urdf/ur3_robot.urdf", [0.15, 0, 0.5], []),
    "ur5": ("ur_description/urdf/ur5_robot.urdf", [0.1, 0, 0.4], []),
    "ur10": ("ur_description/urdf/ur10_robot.urdf", [0.0, 0, 0.4], []),
    "kinova": ("kinova_description/robots/kinova.urdf", [0.1, 0, 0.4], []),
    "xarm7": ("xarm_description/urdf/xarm7.urdf", [0.1, 0, 0.4], []),
    "z1": ("z1_description/urdf/z1.urdf", [0.1, 0, 0.5], ["--tool", "gripperStator"]),
    "talos_arm": ("talos_data/robots/talos_left_arm.urdf", [0.0, 0, 0.6], []),
}
# Arms that also stand on a base with mecanum wheels
FREE = ["ur5", "ur10", "kinova", "panda", "xarm7"]
# URDF, and parts of the message with which it is refused if nobody says which drive it has
REFUSED = {
    "tiago_pro": ("tiago_pro_description/robots/tiago_pro.urdf", ["4 wheels", "mecanum", "wheel_front_left_joint"]),
    "pr2": ("pr2_description/urdf/pr2.urdf", ["no pair of driven wheels", "--drive omnidirectional"]),
}
# Robots of repositories: which commit, which URDF, digests of the files that count, arguments of `robot init`
REPOSITORIES = tomllib.loads((pathlib.Path(__file__).parent / "repositories.toml").read_text())
# This project's own robots with meshes, in assets/robots
OWN = ["porter", "shuttle"]
ROBOTS = pathlib.Path(__file__).resolve().parents[2] / "assets/robots"
WORLDS = [f"environment-{i}" for i in (1, 2, 3, 4)]
MAX_DIFFERENCE = 1e-9
# of the loads that motors are shown to hold and not to hold in MuJoCo, from what `robot check` says
LOAD_MARGIN = 0.03
# of a hull from its mesh, as a share of the mesh's diagonal
MAX_HULL_DIFFERENCE = 0.02
# of a mesh in parts: the cubes that these are made of, along the mesh's longest extent
CUBES = 63
MIN_SHARE_ARRIVED = 0.95
# An arm for which no posture is found
NO_POSTURE = ["talos_arm"]
MIN_ROBOTS, MIN_OMNIDIRECTIONAL = 8, 3
MAX_GRASP_ERROR_M = 0.03
USUAL_OBJECT_KG = 4.0


WHEELS = {"left": (0.0, 0.19), "right": (0.0, -0.19)}
MECANUM = {f"{end}_{side}_mecanum": (x, y) for end, x in (("front", 0.14), ("rear", -0.14)) for side, y in (("left", 0.16), ("right", -0.16))}


def on_base(arm: pathlib.Path, at: list[float], file: pathlib.Path, wheels: dict = WHEELS) -> None:
    """Writes a URDF of the arm on a round base of 0.5 m with these wheels."""
    robot = ET.parse(arm).getroot()
    children = {j.find("child").get("link") for j in robot.findall("joint")}
    (root,) = [link.get("name") for link in robot.findall("link") if link.get("name") not in children]

    def add(xml: str) -> None:
        robot.append(ET.fromstring(xml))

    def link(name: str, mass: float, moments: list[float], xyz: str, rpy: str, shape: str) -> None:
        origin = f'<origin xyz="{xyz}" rpy="{rpy}"/>'
        ixx, iyy, izz = moments
        add(
            f'<link name="{name}"><inertial>{origin}<mass value="{mass}"/>'
            f'<inertia ixx="{ixx}" ixy="0" ixz="0" iyy="{iyy}" iyz="0" izz="{izz}"/></inertial>'
            f"<visual>{origin}<geometry>{shape}</geometry></visual>"
            f"<collision>{origin}<geometry>{shape}</geometry></collision></link>"
        )

    link("cart", 60, [1.7, 1.7, 1.9], "0 0 0.21", "0 0 0", '<cylinder radius="0.25" length="0.34"/>')
    for side, (x, y) in wheels.items():
        shape = '<cylinder radius="0.08" length="0.04"/>'
        link(f"cart_{side}_wheel", 2, [0.0035, 0.0035, 0.0064], "0 0 0", "0 0 0", shape)
        add(
            f'<joint name="cart_{side}_wheel_joint" type="continuous"><parent link="cart"/>'
            f'<child link="cart_{side}_wheel"/><origin xyz="{x} {y} 0.08" rpy="-1.5707963267948966 0 0"/>'
            f'<axis xyz="0 0 1"/><limit effort="20" velocity="13"/></joint>'
        )
    x, y, z = at
    add(
        f'<joint name="cart_arm_joint" type="fixed"><parent link="cart"/><child link="{root}"/>'
        f'<origin xyz="{x} {y} {z}"/></joint>'
    )
    ET.ElementTree(robot).write(file)


def without_shapes(urdf: pathlib.Path) -> str:
    """The text of a URDF for kinematics and masses, as urdfdom reads it: of shapes it does not know some, and it asks
    for all numbers of a limit."""
    robot = ET.parse(urdf).getroot()
    for link in robot.iter("link"):
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            link.remove(shape)
    for limit in robot.iter("limit"):
        for key in ("effort", "velocity"):
            limit.set(key, limit.get(key, "0"))
    return ET.tostring(robot, encoding="unicode")


def grasp_in_tool(robot: dict) -> pinocchio.SE3:
    """The pose of the grasp in the tool's frame."""
    rpy = numpy.radians(robot.get("grasp_rpy_deg", [0, 0, 0]))
    return pinocchio.SE3(pinocchio.rpy.rpyToMatrix(rpy), numpy.array(robot.get("grasp_xyz_m", [0.0, 0, 0])))


def of_hold(robot: dict) -> dict[str, float]:
    """The positions (rad or m) of a robot file's joints under `[hold]`."""
    return {
        name: entry["position_m"] if "position_m" in entry else numpy.radians(entry["angle_deg"])
        for name, entry in robot.get("hold", {}).items()
    }


def differences(urdf: pathlib.Path, file: pathlib.Path, checked: dict) -> dict[str, float]:
    """The largest differences of `robot check --json` from pinocchio: frames (m and 1), mass (kg), and what the postures hold (a share)."""
    robot = tomllib.loads(file.read_text())
    model = pinocchio.buildModelFromXML(without_shapes(urdf))
    data = model.createData()
    worst = held_by = 0.0
    for posture in checked["postures"]:
        q = pinocchio.neutral(model)
        for name, value in (of_hold(robot) | posture["joints"]).items():
            joint = model.joints[model.getJointId(name)]
            of_circle = [numpy.cos(value), numpy.sin(value)]
            q[joint.idx_q : joint.idx_q + joint.nq] = of_circle if joint.nq == 2 else [value]
        pinocchio.framesForwardKinematics(model, data, q)
        place = lambda link: data.oMf[model.getFrameId(link, pinocchio.FrameType.BODY)]
        wheels = [data.oMi[model.getJointId(wheel["joint"])].translation for wheel in checked["drive"]["wheels"]]
        base = place(robot["base_link"])
        floor = numpy.array([0, 0, -robot.get("base_height_m", 0.0)])
        if wheels:
            middle = base.rotation.T @ (sum(wheels) / len(wheels) - base.translation)
            floor = middle - [0, 0, checked["drive"]["wheel_radius_m"]]
        drive_from_base = pinocchio.SE3(numpy.eye(3), -floor)
        grasp = drive_from_base * base.actInv(place(robot["grasp_frame"])) * grasp_in_tool(robot)
        for ours, theirs in (
            (checked["base"]["drive_from_base"], drive_from_base),
            (posture["drive_from_grasp"], grasp),
        ):
            worst = max(worst, abs(numpy.array(ours) - theirs.homogeneous).max())
        # J^T F of a kilogram at the grasp, against the motors' limits
        tool = model.getFrameId(robot["grasp_frame"], pinocchio.FrameType.BODY)
        jacobian = pinocchio.computeFrameJacobian(model, data, q, tool, pinocchio.LOCAL_WORLD_ALIGNED)
        away = place(robot["grasp_frame"]).rotation @ grasp_in_tool(robot).translation
        lifted = base.rotation[:, 2] @ (jacobian[:3] - pinocchio.skew(away) @ jacobian[3:])
        of_arm = [model.joints[model.getJointId(name)].idx_v for name in posture["joints"]]
        payloads = [model.effortLimit[i] / abs(9.81 * lifted[i]) for i in of_arm if model.effortLimit[i] > 0 and lifted[i] != 0]
        held_by = max(held_by, abs(posture["holds_kg"] / min(payloads) - 1))
    mass = sum(inertia.mass for inertia in model.inertias) + robot.get("base_mass_kg", 0.0)
    return {"frames": worst, "mass": abs(checked["base"]["mass_kg"] + checked["arm_mass_kg"] - mass), "holds": held_by}


def outside(model: coal.BVHModelBase, parts: list) -> float:
    """How far a mesh's surface lies outside its parts at most: at 20,000 points, spread by area."""
    triangles = [model.tri_indices(i) for i in range(model.num_tris)]
    corners = model.vertices()[[[triangle[i] for i in range(3)] for triangle in triangles]]
    sides = corners[:, 1:] - corners[:, :1]
    areas = numpy.linalg.norm(numpy.cross(sides[:, 0], sides[:, 1]), axis=1)
    generator = numpy.random.default_rng(1)
    chosen = generator.choice(len(corners), 20_000, p=areas / areas.sum())
    weights = generator.dirichlet(numpy.ones(3), 20_000)
    points = numpy.einsum("ni,nij->nj", weights, corners[chosen])
    planes = [scipy.spatial.ConvexHull(part).equations for part in parts]
    return float(numpy.min([(points @ p[:, :3].T + p[:, 3]).max(1) for p in planes], axis=0).max())


def mesh_file(name: str, folder: pathlib.Path, urdf: pathlib.Path) -> pathlib.Path:
    """A mesh by its name in a URDF: relative to the URDF, or in a package at or below a folder."""
    if not name.startswith("package://"):
        return urdf.parent / name
    package, rest = name.removeprefix("package://").split("/", 1)
    places = [folder, *folder.rglob(package)] if folder.name == package else folder.rglob(package)
    return next((place / rest for place in places if (place / rest).exists()), folder / name.removeprefix("package://"))


def digest(files: list[pathlib.Path]) -> str:
    """SHA-256 of the SHA-256 of files, in hexadecimal, one a line."""
    each = [hashlib.sha256(file.read_bytes()).hexdigest() + "\n" for file in files]
    return hashlib.sha256("".join(each).encode()).hexdigest()


def hull_differences(snapshot: pathlib.Path, folder: pathlib.Path, urdf: pathlib.Path) -> list[float]:
    """For every collision mesh, the largest difference of its hull in a snapshot from the mesh as read by Assimp, in
    200 directions, as a share of the mesh's diagonal. Nothing of a hull lies outside its mesh's. Of a mesh in parts,
    what stands out by more than a cube; nothing of its surface lies outside all parts."""
    data = snapshot.read_bytes()
    # CBOR after the head; its first key is `scenario`
    scenario = cbor2.loads(data[data.index(b"hscenario") - 1 :])["scenario"]
    pending, hulls = [scenario], {}
    while pending:
        value = pending.pop()
        if isinstance(value, dict):
            hulls |= value.get("hulls") or {}
            pending.extend(value.values())
    directions = numpy.random.default_rng(1).normal(size=(200, 3))
    directions /= numpy.linalg.norm(directions, axis=1)[:, None]
    loader, shares = coal.MeshLoader(), []
    for name, hull in hulls.items():
        model = loader.load(str(mesh_file(name, folder, urdf)), numpy.ones(3))
        mesh = model.vertices()
        diagonal = numpy.linalg.norm(mesh.max(0) - mesh.min(0))
        in_parts = isinstance(hull[0][0], list)
        vertices = numpy.concatenate(hull) if in_parts else numpy.array(hull)
        lacks = (mesh @ directions.T).max(0) - (vertices @ directions.T).max(0)
        if in_parts:
            cube = math.sqrt(3) * (mesh.max(0) - mesh.min(0)).max() / CUBES
            is_right = outside(model, hull) < 1e-6 * diagonal
            shares.append(max(0.0, -lacks.min() - cube) / diagonal if is_right else numpy.inf)
        else:
            shares.append(abs(lacks).max() / diagonal if lacks.min() > -1e-6 else numpy.inf)
    return shares


def object_mass(posture: dict) -> float:
    """The mass (kg) of the object that a robot carries from a posture: the usual one, or as much as its motors hold at
    rest with a reserve of a fifth."""
    held = posture["holds_kg"]
    return USUAL_OBJECT_KG if held is None else min(USUAL_OBJECT_KG, math.floor(10 * 0.8 * 2 * held) / 10)


def scaled(world: pathlib.Path, factor: float, width: float, mass: float, file: pathlib.Path) -> None:
    """Writes a world for a robot of another width: all lengths in the plane are scaled. The object has this mass (kg)."""

    def numbers(match: re.Match) -> str:
        values = [float(value) * factor for value in match[2].split(",")]
        return f"{match[1]} = [{', '.join(f'{value:.5f}' for value in values)}]"

    text = re.sub(r"(?m)^(center_m|size_m|start_m|target_m) = \[([^\]]*)\]", numbers, world.read_text())
    text = re.sub(r"(?m)^robot_width_m = .*$", f"robot_width_m = {width}", text)
    assert "[object]" not in text
    file.write_text(f"{text}\n[object]\nshape = \"beam\"\nsize_m = [1.2, 0.1, 0.1]\nmass_kg = {mass}\n")


class Gallery:
    """The program, with the data's packages in its environment, and a folder to work in."""

    def __init__(self, program: str, robots: pathlib.Path, work: pathlib.Path, seeds: int):
        self.program, self.robots, self.work, self.seeds = program, robots, work, seeds
        # $PREFIX/share/example-robot-data/robots
        self.environment = os.environ | {"AMENT_PREFIX_PATH": str(robots.parents[2]), "NO_COLOR": "1"}
        self.faults: list[str] = []
        # the drives of the robots that pass
        self.passed: list[str] = []
        # what the book's pages tell, by robot
        self.told: dict[str, dict] = {}

    def cocarry(self, *arguments: str) -> subprocess.CompletedProcess:
        command = [self.program, *map(str, arguments)]
        return subprocess.run(command, env=self.environment, capture_output=True, text=True, cwd=self.work)

    def check(self, is_good: bool, fault: str) -> None:
        if not is_good:
            self.faults.append(fault)

    def refused(self, name: str, urdf: pathlib.Path, parts: list[str]) -> None:
        """A base that cannot be expressed is refused by name, and nothing is written."""
        file = self.work / f"{name}-refused.toml"
        said = self.cocarry("robot", "init", urdf, "-o", file)
        self.check(said.returncode == 2 and not file.exists(), f"{name}: exit code {said.returncode}")
        self.check(all(part in said.stderr for part in parts), f"{name}: {said.stderr}")
        print(f"{name:14} refused: {' '.join(said.stderr.split('robots/')[-1].split())[:90]}...")

    def own(self, name: str) -> None:
        """One of the project's own robots: its files are what the script writes, and it carries."""
        folder = self.work / "own"
        if not folder.exists():
            folder.mkdir()
            (folder / "make.py").write_bytes((ROBOTS / "make.py").read_bytes())
            subprocess.run([sys.executable, folder / "make.py"], check=True)
        for file in [ROBOTS / f"{name}.urdf", *sorted((ROBOTS / name).iterdir())]:
            made = folder / file.relative_to(ROBOTS)
            self.check(made.exists() and made.read_bytes() == file.read_bytes(), f"{name}: {file.name} is not what make.py writes")
        self.examine(name, ROBOTS / f"{name}.urdf", [], ROBOTS / f"{name}.toml", ROBOTS)

    def carries(
        self, name: str, urdf: pathlib.Path, arguments: list[str], folder: pathlib.Path | None = None
    ) -> None:
        """Drafts the robot file, compares it with pinocchio, and carries in the four environments. `folder` has the
        meshes."""
        file = self.work / f"{name}.toml"
        hold = [word for joint, at in HOLD.get(name, {}).items() for word in ("--hold", f"{joint}={math.degrees(at)}")]
        drafted = self.cocarry("robot", "init", urdf, "-o", file, *arguments, *hold)
        if name in NO_POSTURE:
            self.check(drafted.returncode == 2 and "no posture found" in drafted.stderr, f"{name}: {drafted.stderr}")
            print(f"{name:14} no posture found")
            return
        if drafted.returncode != 0:
            self.check(False, f"{name}: {drafted.stderr}")
            return
        self.examine(name, urdf, arguments, file, folder or self.robots.parents[1])

    def of_repository(self, name: str, entry: dict, folder: pathlib.Path | None) -> None:
        """A robot of a repository, if there is a clone of it in the folder, with the files that the table has."""
        repository = REPOSITORIES["repository"][entry["repository"]]
        clone = folder and folder / entry["repository"].split("/")[1]
        if clone is None or not (clone / entry["urdf"]).exists():
            print(f"{name:14} skipped: no clone of {entry['repository']} at {repository['commit'][:8]} (--repositories)")
            return
        urdf = clone / entry["urdf"]
        meshes = [clone / mesh for mesh in entry.get("meshes", [])]
        lacking = [mesh for mesh in meshes if not mesh.exists()]
        if lacking or digest([urdf, *meshes]) != entry["sha256"]:
            what = f"{lacking[0].name} is missing" if lacking else "its files differ"
            print(f"{name:14} skipped: {what}; expected {entry['repository']} at {repository['commit'][:8]}")
            return
        self.carries(name, urdf, entry.get("arguments", []), clone)

    def examine(
        self, name: str, urdf: pathlib.Path, arguments: list[str], file: pathlib.Path, folder: pathlib.Path
    ) -> None:
        """Compares a robot, whose meshes are below a folder, with pinocchio, and carries in the four environments."""
        said = self.cocarry("robot", "check", file, "--json")
        if said.returncode != 0:
            self.check(False, f"{name}: {said.stderr}")
            return
        checked = json.loads(said.stdout)
        self.told[name] = {"checked": checked, "file": file, "urdf": urdf, "arguments": arguments}
        if self.seeds == 0:
            return
        differs = differences(urdf, file, checked)
        self.check(max(differs.values()) <= MAX_DIFFERENCE, f"{name}: differs from pinocchio: {differs}")
        self.holds(name, urdf, tomllib.loads(file.read_text()), checked)
        width, mass = checked["postures"][0]["needed_width_m"], object_mass(checked["postures"][0])
        snapshot = self.work / f"{name}.snapshot"
        rows = self.episodes(name, file, width, mass)
        self.cocarry("run", f"{name}-{WORLDS[0]}.toml", "--plant", "kinematic", "--robot", file, "--save-at", "1", snapshot)
        hulls = hull_differences(snapshot, folder, urdf)
        self.check(max(hulls, default=0.0) <= MAX_HULL_DIFFERENCE, f"{name}: hulls differ from their meshes: {hulls}")
        arrived = [row for row in rows if row["outcome"] == "arrived"]
        error = max((float(row["position_error_rms_m"]) for row in arrived), default=0.0)
        others = collections.Counter((row["plant"], row["outcome"]) for row in rows if row not in arrived)
        self.told[name] |= {"rows": rows, "object_kg": mass, "arrived": len(arrived), "error_m": error, "others": others}
        is_passed = len(arrived) >= MIN_SHARE_ARRIVED * len(rows)
        self.check(is_passed, f"{name}: {len(arrived)} of {len(rows)} arrived: {others}")
        if rows and is_passed:
            self.passed.append(checked["drive"]["kind"])
        self.check(error < MAX_GRASP_ERROR_M, f"{name}: grasp error {error:.4f} m rms")
        print(
            f"{name:14} {checked['drive']['kind']}, {len(checked['joints'])} joints, {len(checked['postures'])} postures, {width:.2f} m wide, object of {mass} kg; "
            f"frames within {differs['frames']:.0e}, mass within {differs['mass']:.0e} kg, "
            f"what it holds within {differs['holds']:.0e}; "
            f"{len(hulls)} hulls within {100 * max(hulls, default=0.0):.1f} %; "
            f"{len(arrived)} of {len(rows)} arrived, grasp error at most {1000 * error:.1f} mm rms"
            + "".join(f"; {count} {outcome} ({plant})" for (plant, outcome), count in others.items()),
            flush=True,
        )

    def holds(self, name: str, urdf: pathlib.Path, robot: dict, checked: dict) -> None:
        """In MuJoCo, motors with the same limits hold a little less than `robot check` says, and yield to a little more."""
        limits = {joint["name"]: joint["effort_limit"] for joint in checked["joints"]}
        for posture in checked["postures"]:
            if posture["holds_kg"] is None:
                continue
            grasp = (robot["grasp_frame"], grasp_in_tool(robot).translation)
            below, above = (
                motors.hung(urdf.read_bytes(), grasp, of_hold(robot) | posture["joints"], limits, share * posture["holds_kg"])
                for share in (1 - LOAD_MARGIN, 1 + LOAD_MARGIN)
            )
            is_as_said = not below.yields and above.yields and {below.joint, above.joint} == {posture["weakest_joint"]}
            self.check(is_as_said, f"{name}, {posture['name']}: holds {posture['holds_kg']:.2f} kg by {posture['weakest_joint']}; in MuJoCo {below}, {above}")

    def episodes(self, name: str, file: pathlib.Path, width: float, mass: float) -> list[dict]:
        """Rows of episodes in worlds as wide as the robot needs, with an object of this mass (kg)."""
        worlds = []
        for world in WORLDS:
            worlds.append(f"{name}-{world}.toml")
            # the worlds are for robots of 0.5 m
            size = max(width / 0.5, 1.0)
            scaled(self.work / f"{world}.toml", size, max(width, 0.5), mass, self.work / worlds[-1])
        study, out = self.work / f"{name}-study.toml", self.work / f"{name}.csv"
        study.write_text(
            f"worlds = {json.dumps(worlds)}\nplants = [\"kinematic\", \"rapier\"]\n"
            f"robots = {json.dumps([str(file)])}\nseeds = {self.seeds}\n"
        )
        done = self.cocarry("sweep", study, "--output", out)
        self.check(done.returncode == 0, f"{name}: {done.stderr}")
        return list(csv.DictReader(out.open())) if out.exists() else []


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("robots", type=pathlib.Path)
    parser.add_argument("--repositories", type=pathlib.Path, default=os.environ.get("COCARRY_REPOSITORIES"), help="folder with clones of the repositories [default: $COCARRY_REPOSITORIES]")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--pages", action="store_true", help="write the book's pages of the robots")
    parser.add_argument("--pictures", action="store_true", help="write the pictures of the pages; needs Chromium and npm")
    parser.add_argument("--only", nargs="*", help="names of robots")
    arguments = parser.parse_args()
    is_asked = lambda name: not arguments.only or name in arguments.only
    with tempfile.TemporaryDirectory() as folder:
        work, robots = pathlib.Path(folder), arguments.robots.resolve()
        are_pictures_all = arguments.pictures and not arguments.pages
        seeds = 0 if are_pictures_all else arguments.seeds
        gallery = Gallery(str(arguments.program.resolve()), robots, work, seeds)
        for world in WORLDS:
            gallery.check(gallery.cocarry("export", world).returncode == 0, f"no {world}")
        for name, (urdf, options) in filter(lambda item: is_asked(item[0]), MOBILE.items()):
            gallery.carries(name, robots / urdf, options)
        for name, (urdf, at, options) in filter(lambda item: is_asked(item[0]), ARMS.items()):
            on_base(robots / urdf, at, work / f"{name}.urdf")
            gallery.carries(name, work / f"{name}.urdf", options)
        for name in filter(lambda name: is_asked(f"{name}_omni"), FREE):
            urdf, at, options = ARMS[name]
            file = work / f"{name}_omni.urdf"
            on_base(robots / urdf, at, file, MECANUM)
            gallery.carries(f"{name}_omni", file, options)
        for name in filter(is_asked, OWN):
            gallery.own(name)
        clones = arguments.repositories and pathlib.Path(arguments.repositories).resolve()
        for name, entry in filter(lambda item: is_asked(item[0]), REPOSITORIES["robot"].items()):
            gallery.of_repository(name, entry, clones)
        if arguments.pictures:
            pages.pictures(gallery.told, gallery.cocarry, work)
        if arguments.pages:
            pages.write(gallery.told, robots, arguments.seeds, is_all=not arguments.only)
        for name, (urdf, parts) in filter(lambda item: is_asked(item[0]), REFUSED.items()):
            gallery.refused(name, robots / urdf, parts)
    free = gallery.passed.count("omnidirectional")
    if are_pictures_all:
        sys.exit("\n".join(gallery.faults) or None)
    print(f"{len(gallery.passed)} robots reach {MIN_SHARE_ARRIVED:.0%}, {free} of them omnidirectional")
    if not arguments.only:
        gallery.check(len(gallery.passed) >= MIN_ROBOTS and free >= MIN_OMNIDIRECTIONAL, "too few robots pass")
    for fault in gallery.faults:
        print(f"FAILED {fault}", file=sys.stderr)
    sys.exit(1 if gallery.faults else 0)


if __name__ == "__main__":
    main()
