"""Compares exported scenes in MuJoCo with pinocchio and with the program. `check` says how it is run.

What is not equal by construction has a bar, printed with the figure. The statics and the mass matrix are exact;
replayed episodes differ by what two integrators do: see book/src/mujoco.md.
"""

import argparse
import csv
import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
from reference import Reference

ROBOTS = Path("assets/robots")
BUILT_IN = ["carrier", "omni-carrier", "porter", "shuttle"]
WORLDS = [f"environment-{n}" for n in range(1, 5)]
GRAVITY, SIZE, MASS = 9.81, [1.2, 0.1, 0.1], 4.0
PLANNING_STEP = 0.2
# bars: kg m^2 and kg; m and rad; N
MATRIX_BAR, FRAME_BAR, MESH_BAR, STATIC_BAR = 1e-9, 1e-9, 1e-7, 1e-6
# a replayed episode: where the object is (m); forces of either grip over planning steps, as a share of their
# rms with and without the weight that the grip bears at rest. Nearly all of it is the program's step of 10 ms:
# see --steps
END_BAR, ALONG_BAR, FORCE_BAR, MOVING_BAR = 0.002, 0.005, 0.05, 0.25


class Program:
    def __init__(self, path: str, folder: Path):
        self.path, self.folder, self.count = path, folder, 0

    def run(self, *arguments) -> str:
        command = [self.path, "--quiet", *map(str, arguments)]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"{' '.join(command)}: {done.stderr}")
        return done.stdout

    def export(self, world: str, *arguments) -> Path:
        self.count += 1
        file = self.folder / f"{self.count}.xml"
        self.run("export", world, "--mjcf", file, *arguments)
        return file

    def episode(self, world: str, *arguments) -> "Log":
        self.count += 1
        xml, motors = self.folder / f"{self.count}.xml", self.folder / f"{self.count}.csv"
        said = self.run("export", world, "--mjcf", xml, "--motors", motors, *arguments)
        outcome = next(line.split("the episode ended: ")[1] for line in said.splitlines() if "ended: " in line)
        with motors.open(newline="") as file:
            names = next(csv.reader(file))
        log = Log(xml, names, np.loadtxt(motors, delimiter=",", skiprows=1, ndmin=2), outcome)
        motors.unlink()
        return log


@dataclass
class Log:
    xml: Path
    names: list[str]
    rows: np.ndarray
    outcome: str

    def columns(self, *names: str) -> np.ndarray:
        return self.rows[:, [self.names.index(name) for name in names]]

    def pose(self, body: str) -> tuple[np.ndarray, np.ndarray]:
        keys = ["x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"]
        both = self.columns(*(f"{body}_{key}" for key in keys))
        return both[:, :3], both[:, 3:]

    def force(self, grip: str) -> np.ndarray:
        return self.columns(*(f"{grip}_force_{axis}_n" for axis in "xyz"))


@dataclass
class Figures:
    """Of every comparison the largest difference, with its bar."""

    rows: dict[str, list] = field(default_factory=dict)

    def add(self, what: str, unit: str, bar: float, value: float) -> None:
        row = self.rows.setdefault(what, [unit, bar, []])
        row[2].append(float(value))

    def told(self) -> bool:
        is_good = True
        for what, (unit, bar, values) in self.rows.items():
            worst, median = max(values), float(np.median(values))
            within = worst <= bar
            is_good &= within
            print(f"{'ok  ' if within else 'OVER'} {what}: largest {worst:.3g}{unit}, median {median:.3g}{unit} of {len(values)}; bar {bar:g}{unit}")
        return is_good


def loaded(file: Path) -> mujoco.MjModel:
    """The model, which MuJoCo has nothing to say about."""
    said = []
    mujoco.set_mju_user_warning(said.append)
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("start").id)
    mujoco.mj_forward(model, data)
    said += [f"warning {i}" for i, warning in enumerate(data.warning) if warning.number]
    if said:
        raise SystemExit(f"{file}: {said}")
    return model


def at_start(model: mujoco.MjModel) -> mujoco.MjData:
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("start").id)
    mujoco.mj_forward(model, data)
    return data


def dofs(model: mujoco.MjModel, joints: list[str]) -> list[int]:
    names = [f"base_{axis}" for axis in ("x", "y", "yaw")] + [f"robot/{name}" for name in joints] + [f"grip_{axis}" for axis in "xyz"]
    turn = model.joint("grip_turn").dofadr[0]
    return [model.joint(name).dofadr[0] for name in names] + [turn, turn + 1, turn + 2]


def compare_masses(figures: Figures, model: mujoco.MjModel, reference: Reference, generator: np.random.Generator) -> None:
    """Masses, frames and the mass matrix, at the start and in random configurations."""
    data = at_start(model)
    full, order = np.zeros((model.nv, model.nv)), dofs(model, reference.joints)
    for n in range(20):
        if n:
            for i in range(model.njnt):
                at, (low, high) = model.jnt_qposadr[i], model.jnt_range[i]
                if model.joint(i).name == "grip_turn":
                    turn = generator.normal(size=4)
                    data.qpos[at : at + 4] = turn / np.linalg.norm(turn)
                elif model.joint(i).name.startswith("grip_"):
                    data.qpos[at] = generator.uniform(-0.02, 0.02)
                else:
                    data.qpos[at] = generator.uniform(low, high) if model.jnt_limited[i] else generator.uniform(-3, 3)
            mujoco.mj_forward(model, data)
        position = lambda name: data.joint(name).qpos
        joints = {name: position(f"robot/{name}")[0] for name in reference.joints}
        base = np.concatenate([position(f"base_{axis}") for axis in ("x", "y", "yaw")])
        place = np.concatenate([position(f"grip_{axis}") for axis in "xyz"])
        q = reference.configuration(base, joints, place, position("grip_turn"))
        mujoco.mj_fullM(model, data, full)
        ours = full[np.ix_(order, order)]
        figures.add("mass matrix with the object - pinocchio's", " kg m^2", MATRIX_BAR, np.abs(ours - reference.mass_matrix(q, reference.joints)).max())
        for name, (pose, inertia) in reference.bodies(q).items():
            if name == "grip":
                continue
            joint = {"base": "base_x", "grip_turn": "grip_turn"}.get(name, f"robot/{name}")
            body = model.joint(joint).bodyid[0]
            figures.add("mass of a body", " kg", MATRIX_BAR, abs(model.body_mass[body] - inertia.mass))
            figures.add("centre of mass of a body", " m", FRAME_BAR, np.abs(model.body_ipos[body] - inertia.lever).max())
            apart = np.abs(data.xpos[body] - pose.translation).max() + np.abs(data.xmat[body].reshape(3, 3) - pose.rotation).max()
            figures.add("frame of a body", "", FRAME_BAR, apart)
    compare_shapes(figures, model, at_start(model), reference)


def compare_shapes(figures: Figures, model: mujoco.MjModel, data: mujoco.MjData, reference: Reference) -> None:
    """The frame of every link that has collision shapes, at the start."""
    base = np.array([data.joint(f"base_{axis}").qpos[0] for axis in ("x", "y", "yaw")])
    joints = {name: data.joint(f"robot/{name}").qpos[0] for name in reference.joints}
    shapes = reference.shapes(base, joints)
    for i in range(model.ngeom):
        name = model.geom(i).name
        if not name.startswith("robot/"):
            continue
        link = name.removeprefix("robot/")
        link = link if link in shapes else link.rsplit(":", 1)[0]
        at = pin.SE3(data.geom_xmat[i].reshape(3, 3), data.geom_xpos[i])
        if model.geom_type[i] == mujoco.mjtGeom.mjGEOM_MESH:
            mesh = model.geom_dataid[i]
            turn = np.zeros(9)
            mujoco.mju_quat2Mat(turn, model.mesh_quat[mesh])
            at = at * pin.SE3(turn.reshape(3, 3), model.mesh_pos[mesh]).inverse()
        apart = [np.abs(at.homogeneous - shape.homogeneous).max() for shape in shapes[link]]
        is_mesh = model.geom_type[i] == mujoco.mjtGeom.mjGEOM_MESH
        # MuJoCo has vertices in single precision
        what, bar = ("frame of a hull", MESH_BAR) if is_mesh else ("frame of a primitive", FRAME_BAR)
        figures.add(what, "", bar, min(apart))


def compare_statics(figures: Figures, model: mujoco.MjModel, joints: list[str]) -> None:
    """At rest, with motors that bear the load, each grip carries half of the object."""
    data = at_start(model)
    data.qacc[:] = 0
    mujoco.mj_inverse(model, data)
    for name in joints:
        actuator, joint = model.actuator(f"robot/{name}"), model.joint(f"robot/{name}")
        # what it takes to stay, beyond what springs and motors do
        lacking = data.qfrc_inverse[joint.dofadr[0]] - data.qfrc_actuator[joint.dofadr[0]]
        data.ctrl[actuator.id] += lacking / actuator.gainprm[0]
    mujoco.mj_step(model, data, round(3 / model.opt.timestep))
    for grip in ("gripper", "hand"):
        forces = np.array([data.actuator(f"{grip}_{axis}").force[0] for axis in "xyz"])
        figures.add(f"{grip} at rest - m g / 2", " N", STATIC_BAR, np.abs(forces - [0, 0, MASS * GRAVITY / 2]).max())


@dataclass
class Replayed:
    end: float
    most: float
    # of gripper and hand: rms difference as a share of rms, with and without the weight that they bear
    forces: dict[str, tuple[float, float]]


def replayed(log: Log, timestep: float | None = None) -> Replayed:
    model = loaded(log.xml)
    if timestep is not None:
        model.opt.timestep = timestep
    data = at_start(model)
    times = log.columns("time_s")[:, 0]
    period = times[0]
    inner = max(1, round(period / model.opt.timestep))
    model.opt.timestep = period / inner
    actuators = [i for i in range(model.nu) if not model.actuator(i).name.startswith("gripper_")]
    controls = log.columns(*(model.actuator(i).name for i in actuators))
    gripper, hand = ([model.actuator(f"{grip}_{axis}").id for axis in "xyz"] for grip in ("gripper", "hand"))
    mocap = [model.body(name).mocapid[0] for name in ("hand", "torso")]
    poses = [log.pose(name) for name in ("hand", "torso")]
    before = [(data.mocap_pos[i].copy(), data.mocap_quat[i].copy()) for i in mocap]
    grasp, held = data.site("grasp"), data.site("hand")
    front, rear = data.site("front"), data.body("object")
    places, _ = log.pose("object")
    apart, forces = [], np.zeros((len(times), 2, 3))
    for k in range(len(times)):
        data.ctrl[actuators] = controls[k]
        after = []
        for (place, turn), (positions, turns) in zip(before, poses):
            turned = turns[k] if turns[k] @ turn >= 0 else -turns[k]
            after.append((positions[k], turned))
        force = np.zeros((2, 3))
        for j in range(inner):
            share = j / inner
            for i, (place, turn), (to, toward) in zip(mocap, before, after):
                data.mocap_pos[i] = place + share * (to - place)
                mixed = turn + share * (toward - turn)
                data.mocap_quat[i] = mixed / np.linalg.norm(mixed)
            mujoco.mj_step(model, data)
            force[0] += grasp.xmat.reshape(3, 3) @ data.actuator_force[gripper]
            force[1] += held.xmat.reshape(3, 3) @ data.actuator_force[hand]
        before = after
        forces[k] = force / inner
        if k % 20 == 19 or k == len(times) - 1:
            mujoco.mj_kinematics(model, data)
            middle = (front.xpos + rear.xpos) / 2
            apart.append(np.linalg.norm(middle - places[k]))
    steps = round(PLANNING_STEP / period)
    count = len(times) // steps
    mean = lambda values: values[: count * steps].reshape(count, steps, 3).mean(axis=1)
    found, weight = {}, np.array([0, 0, MASS * GRAVITY / 2])
    for i, grip in enumerate(("gripper", "hand")):
        ours, theirs = mean(log.force(grip)), mean(forces[:, i])
        rms = lambda values: np.sqrt((values**2).sum(axis=1).mean())
        found[grip] = rms(theirs - ours) / rms(ours), rms(theirs - ours) / rms(ours - weight)
    return Replayed(apart[-1], max(apart), found)


def compare_episodes(figures: Figures, program: Program, seeds: int) -> None:
    ended = {}
    for world in WORLDS:
        for seed in range(seeds):
            log = program.episode(world, "--seed", seed)
            ended[log.outcome] = ended.get(log.outcome, 0) + 1
            if log.outcome != "arrived":
                continue
            found = replayed(log)
            figures.add("replayed episode: object at its end", " m", END_BAR, found.end)
            figures.add("replayed episode: object at any time", " m", ALONG_BAR, found.most)
            for grip, (whole, moving) in found.forces.items():
                figures.add(f"replayed episode: force of the {grip}, rms of planning steps", "", FORCE_BAR, whole)
                figures.add(f"the same as a share of the force without the weight that the {grip} bears", "", MOVING_BAR, moving)
        print(f"{world}: {sum(ended.values())} episodes so far, {ended}", flush=True)


def compare_steps(program: Program) -> None:
    """How far apart the engines are, by their step lengths."""
    print("object at the end of the episode of seed 0 in each environment, and rms of the forces' difference (without the weight)")
    for rate in (100, 240, 1000):
        logs = [program.episode(world, "--seed", 0, "--physics-rate", rate) for world in WORLDS]
        for step in (0.002, 0.001, 0.0005, 0.00025) if rate == 100 else (0.0005,):
            found = [replayed(log, step) for log in logs]
            ends = ", ".join(f"{1e3 * one.end:.2f}" for one in found)
            shares = [f"{grip} " + ", ".join(f"{100 * one.forces[grip][0]:.2f} ({100 * one.forces[grip][1]:.1f})" for one in found) + " %" for grip in ("gripper", "hand")]
            print(f"rapier at {rate} Hz, MuJoCo at {1e3 * step:g} ms: {ends} mm; {'; '.join(shares)}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description="`cocarry export --mjcf` against pinocchio, MuJoCo and the program")
    parser.add_argument("program")
    parser.add_argument("--seeds", type=int, default=5, help="how many episodes are replayed in each environment")
    parser.add_argument("--steps", action="store_true", help="compare step lengths of both engines")
    arguments = parser.parse_args()
    figures, generator = Figures(), np.random.default_rng(1)
    with tempfile.TemporaryDirectory() as folder:
        program = Program(arguments.program, Path(folder))
        for robot in BUILT_IN:
            file = ROBOTS / f"{robot}.toml"
            said = json.loads(program.run("robot", "check", file, "--json"))
            reference = Reference(file, said, SIZE, MASS)
            for world in WORLDS:
                model = loaded(program.export(world, "--robot", file))
            for posture in said["postures"]:
                model = loaded(program.export(WORLDS[-1], "--robot", file, "--posture", posture["name"]))
                compare_masses(figures, model, reference, generator)
                compare_statics(figures, model, reference.joints)
        print(f"{len(BUILT_IN)} robots in {len(WORLDS)} environments: loaded without a warning", flush=True)
        compare_episodes(figures, program, arguments.seeds)
        is_good = figures.told()
        if arguments.steps:
            compare_steps(program)
    sys.exit(0 if is_good else 1)


if __name__ == "__main__":
    main()
