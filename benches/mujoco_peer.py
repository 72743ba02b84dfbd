"""The scene of `benches/physics.rs` in MuJoCo, as a peer: what a control period of 0.2 s takes there.

    pip install mujoco
    python benches/mujoco_peer.py             # MuJoCo alone
    python benches/mujoco_peer.py --compare    # and the plant of this repository in the same run, in turns

The same URDF (wheels and fingers held, fixed links fused, weight compensated), base on two slides and a hinge driven by velocity motors, arm on position
motors with the stiffness, damping and effort limits of `motor.rs`, a free beam of 4 kg held by soft welds with the stiffness of `grip.rs`, a mocap
human, the boxes of Environment 4. Time is that of `mj_step` alone, in the median over 200 periods; `deflection` is the most by which a grip gives way.
Errors are the most by which the object is off where it is with a very short step of the same engine, so that each engine is judged at the step it needs.
`--compare` takes the fastest of some rounds of both.
"""

import argparse
import json
import re
import subprocess
import time
import tomllib
from pathlib import Path

import mujoco
import numpy as np

ROOT = Path(__file__).resolve().parent.parent
PERIOD, TICKS = 0.2, 200
# steps per second: its usual one among them, and the one that others are measured against
RATES, FINE = (4000, 2000, 1000, 500, 240), 8000
MASS, REACH = 4.0, 0.6
GRIPPER, HAND = 20_000.0, 1200.0


def robot() -> tuple[mujoco.MjSpec, dict[str, float]]:
    """The robot without its world, and the effort limit of every joint of the arm (Nm)."""
    text = (ROOT / "assets/robots/carrier.urdf").read_text()
    text = re.sub(r'(<joint name="\w+_(?:wheel|finger)_joint" type=)"\w+"', r'\1"fixed"', text)
    text = text.replace('<mimic joint="left_finger_joint"/>', "")
    options = '<mujoco><compiler fusestatic="true" discardvisual="true"/></mujoco>'
    spec = mujoco.MjSpec.from_string(re.sub(r'(<robot name="\w+">)', rf"\1{options}", text, count=1))
    spec.compiler.degree = False
    found = re.finditer(r'<joint name="(\w+)" type="(?:revolute|continuous)">.*?effort="([\d.]+)"', text, re.S)
    return spec, {m.group(1): float(m.group(2)) for m in found}


def body(spec: mujoco.MjSpec, name: str) -> mujoco.MjsBody:
    return next(b for b in spec.bodies if b.name == name)


def scene() -> tuple[mujoco.MjSpec, dict[str, float], dict[str, float]]:
    """The whole scene; the position that each joint starts at; each arm joint's effort limit."""
    spec, efforts = robot()
    kinds = mujoco.mjtGeom
    for moved in spec.bodies:
        moved.gravcomp = 1
    for shape in spec.geoms:
        shape.contype, shape.conaffinity = 1, 2
    base = body(spec, "base_link")
    for name, kind, axis in [("x", "SLIDE", [1, 0, 0]), ("y", "SLIDE", [0, 1, 0]), ("yaw", "HINGE", [0, 0, 1])]:
        base.add_joint(name=name, type=getattr(mujoco.mjtJoint, f"mjJNT_{kind}"), axis=axis)
        motor = spec.add_actuator(name=name, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=name)
        motor.set_to_velocity(kv=20_000.0)
        motor.forcerange, motor.forcelimited = [-400, 400], True
    for name, effort in efforts.items():
        motor = spec.add_actuator(name=name, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=name)
        motor.set_to_position(kp=300 * effort, kv=6 * effort)
        motor.forcerange, motor.forcelimited = [-effort, effort], True

    world = tomllib.loads((ROOT / "worlds/environment-4.toml").read_text())
    for box in world["obstacle"]:
        half = [*(side / 2 for side in box["size_m"]), box["height_m"] / 2]
        at = [*box["center_m"], half[2]]
        spec.worldbody.add_geom(type=kinds.mjGEOM_BOX, pos=at, size=half, contype=2, conaffinity=1)

    settings = tomllib.loads((ROOT / "assets/robots/carrier.toml").read_text())
    start = {name: np.deg2rad(angle) for name, angle in settings["posture"][0]["angles_deg"].items()}
    start["x"], start["y"] = world["start_m"]
    height, front = settings["grasp_height_m"], start["x"] + grasp_ahead(spec, start)
    beam = spec.worldbody.add_body(name="beam", pos=[front + REACH, start["y"], height])
    beam.add_freejoint()
    beam.add_geom(type=kinds.mjGEOM_BOX, size=[REACH, 0.05, 0.05], mass=MASS, contype=1, conaffinity=2)
    hand = spec.worldbody.add_body(name="hand", pos=[front + 2 * REACH, start["y"], height], mocap=True)
    hand.add_geom(type=kinds.mjGEOM_SPHERE, size=[0.04, 0, 0], contype=1, conaffinity=2)
    torso = spec.worldbody.add_body(name="torso", pos=[front + 2 * REACH + 0.35, start["y"], 0.85], mocap=True)
    torso.add_geom(type=kinds.mjGEOM_CAPSULE, size=[0.2, 0.65, 0], contype=1, conaffinity=2)
    grips = [("gripper", body(spec, "grasp_link"), -REACH, GRIPPER), ("hand", hand, REACH, HAND)]
    for name, holder, end, stiffness in grips:
        holder.add_site(name=name)
        beam.add_site(name=f"{name} end", pos=[end, 0, 0])
        weld = spec.add_equality(type=mujoco.mjtEq.mjEQ_WELD, objtype=mujoco.mjtObj.mjOBJ_SITE)
        weld.name1, weld.name2 = name, f"{name} end"
        # what half the beam feels; critically damped
        weld.solref = [-stiffness / (MASS / 2), -2 * np.sqrt(stiffness / (MASS / 2))]
    return spec, start, efforts


def grasp_ahead(spec: mujoco.MjSpec, start: dict[str, float]) -> float:
    """How far ahead of the base the grasp is (m)."""
    alone = spec.copy()
    body(alone, "grasp_link").add_site(name="grasp")
    model = alone.compile()
    data = placed(model, start)
    return data.site("grasp").xpos[0] - start["x"]


def placed(model: mujoco.MjModel, start: dict[str, float]) -> mujoco.MjData:
    data = mujoco.MjData(model)
    for name, position in start.items():
        data.joint(name).qpos = position
    mujoco.mj_forward(model, data)
    return data


def drive(step: float) -> tuple[float, np.ndarray, float]:
    """The drive of `benches/physics.rs` with physics steps of so many seconds: the median time of a period (s), where the beam is after each (m), and the
    largest deflection (m)."""
    spec, start, efforts = scene()
    spec.option.timestep = step
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    model = spec.compile()
    data = placed(model, start)
    first, mocap = data.site("hand end").xpos.copy(), data.mocap_pos.copy()
    steps, times, places, deflection = round(PERIOD / step), [], [], 0.0
    for tick in range(TICKS):
        phase, heading = PERIOD * tick, data.joint("yaw").qpos[0]
        speed = 0.4 * np.sin(0.5 * phase)
        data.actuator("x").ctrl, data.actuator("y").ctrl = speed * np.cos(heading), speed * np.sin(heading)
        data.actuator("yaw").ctrl = 0.3 * np.cos(phase)
        for i, name in enumerate(efforts):
            data.actuator(name).ctrl += 0.1 * np.cos(phase + i) * PERIOD if tick else start[name]
        # the hand goes along with the beam, as a human who is led
        data.mocap_pos[:] = mocap + (data.site("hand end").xpos - first)
        begun = time.perf_counter()
        mujoco.mj_step(model, data, steps)
        times.append(time.perf_counter() - begun)
        places.append(data.body("beam").xpos.copy())
        deflection = max(deflection, *(np.linalg.norm(data.site(n).xpos - data.site(f"{n} end").xpos) for n in ("gripper", "hand")))
    assert np.isfinite(data.qpos).all()
    return float(np.median(times)), np.array(places), deflection


def measured(rates: tuple[int, ...], exact: np.ndarray) -> dict[int, tuple[float, float, float]]:
    """For every rate the time of a period (s), the error (m) and the deflection (m)."""
    found = {}
    for rate in rates:
        period, places, deflection = drive(1 / rate)
        found[rate] = period, float(np.linalg.norm(places - exact, axis=1).max()), deflection
    return found


def ours() -> tuple[dict[int, tuple[float, float]], float, int]:
    """The plant of this repository: for every rate the time of a period (s) and the error (m); how many times real time a whole episode is at which
    rate."""
    command = ["cargo", "bench", "--quiet", "--bench", "physics", "--", "--peer"]
    printed = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    rows = [json.loads(line) for line in printed.splitlines() if line.startswith("{")]
    periods = {row["rate_hz"]: (row["period_s"], row["error_m"]) for row in rows if "period_s" in row}
    (whole,) = [row for row in rows if "episode_s" in row]
    return periods, whole["simulated_s"] / whole["episode_s"], whole["rate_hz"]


def told(period: float, rate: float, error: float) -> str:
    return f"{rate:4.0f} Hz: {period * 1e6:7.1f} us a period, {period / PERIOD / rate * 1e6:5.2f} us a step, {PERIOD / period:4.0f} times real time; error {error * 1e3:6.3f} mm"


def main() -> None:
    parser = argparse.ArgumentParser(description="The scene of benches/physics.rs in MuJoCo")
    parser.add_argument("--compare", action="store_true", help="and the plant of this repository, in turns")
    parser.add_argument("--rounds", type=int, default=3, help="how often; the fastest counts")
    args = parser.parse_args()
    exact = drive(1 / FINE)[1]
    theirs, plant, whole, rate = {}, {}, 0.0, 0.0
    for _ in range(args.rounds):
        for key, found in measured(RATES, exact).items():
            theirs[key] = min(found, theirs.get(key, found))
        if args.compare:
            periods, speed, rate = ours()
            whole = max(whole, speed)
            for key, found in periods.items():
                plant[key] = min(found, plant.get(key, found))
    print(f"MuJoCo {mujoco.__version__}, control period of {PERIOD} s in Environment 4")
    for key, (period, error, deflection) in theirs.items():
        print(" ", told(period, key, error) + f"; deflection at most {deflection * 1e3:.1f} mm")
    if not args.compare:
        return
    print("this repository, the same drive")
    for key, (period, error) in plant.items():
        print(" ", told(period, key, error))
    usual = PERIOD / theirs[500][0]
    print(f"whole episodes, control included, at {rate:.0f} Hz: {whole:.0f} times real time, {whole / usual:.2f} times MuJoCo's physics alone at 2 ms")


if __name__ == "__main__":
    main()
