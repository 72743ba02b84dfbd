"""The scene of `benches/physics.rs` in MuJoCo, as a peer: what a control period of 0.2 s takes there.

    pip install mujoco
    python benches/mujoco_peer.py             # MuJoCo alone
    python benches/mujoco_peer.py --compare    # and the plant of this repository in the same run, in turns

The scene is that of `cocarry export environment-4 --mjcf`, whose motors and grips are those of the plant. Time is that of `mj_step` alone, in the median over
200 periods; `deflection` is the most by which a grip gives way, that of the gripper's vertical spring at rest included.
Errors are the most by which the object is off where it is with a very short step of the same engine, so that each engine is judged at the step it needs.
`--compare` takes the fastest of some rounds of both, and keeps its rows in `benches/results.json`, from which the book's table is made.
"""

import argparse
import datetime
import json
import os
import subprocess
import tempfile
import time
import tomllib
from pathlib import Path

import mujoco
import numpy as np

ROOT = Path(__file__).resolve().parent.parent
PERIOD, TICKS = 0.2, 200
# how often the hand catches up in a period; every rate has a whole number of steps in between
PARTS = 4
# steps per second: its usual one among them, and the one that others are measured against
RATES, FINE = (4000, 2000, 1000, 500, 240), 8000
WORLD = "environment-4"


def scene(program: str) -> mujoco.MjModel:
    """The scene that the program writes, with the team at the world's start and heading along x, as in the bench."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scene.xml"
        subprocess.run([program, "--quiet", "export", WORLD, "--mjcf", file], check=True, stdout=subprocess.DEVNULL)
        model = mujoco.MjModel.from_xml_path(str(file))
    start = model.key("start")
    data = at_start(model)
    held = data.body("object")
    heading = np.arctan2(held.xmat[3], held.xmat[0])
    half = (data.site("front").xpos - held.xpos) / 2
    middle = (held.xpos + half)[:2]
    turn = np.array([[np.cos(heading), np.sin(heading)], [-np.sin(heading), np.cos(heading)]])
    moved = lambda place: np.array(tomllib.loads((ROOT / f"worlds/{WORLD}.toml").read_text())["start_m"]) + turn @ (place - middle)
    start.qpos[:2] = moved(start.qpos[:2])
    start.qpos[2] -= heading
    for place, quaternion in zip(start.mpos.reshape(-1, 3), start.mquat.reshape(-1, 4)):
        place[:2] = moved(place[:2])
        quaternion[:] = [1, 0, 0, 0]
    return model


def at_start(model: mujoco.MjModel) -> mujoco.MjData:
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("start").id)
    mujoco.mj_forward(model, data)
    return data


def drive(model: mujoco.MjModel, step: float) -> tuple[float, np.ndarray, float]:
    """The drive of `benches/physics.rs` with physics steps of so many seconds: the median time of a period (s), where the object is after each (m), and the
    largest deflection (m)."""
    model.opt.timestep = step
    data = at_start(model)
    arm = [i for i in range(model.nu) if model.actuator(i).name.startswith("robot/")]
    front, hand, rear, grasp = data.site("front"), data.site("hand"), data.body("object"), data.site("grasp")
    first, mocap, before = front.xpos.copy(), data.mocap_pos.copy(), front.xpos.copy()
    base, along = ([model.actuator(f"{what}_{axis}").id for axis in axes] for what, axes in (("base", ("x", "y", "yaw")), ("hand", "xyz")))
    steps, times, places, deflection = round(PERIOD / PARTS / step), [], [], 0.0
    for tick in range(TICKS):
        phase, heading = PERIOD * tick, data.joint("base_yaw").qpos[0]
        speed = 0.4 * np.sin(0.5 * phase)
        data.ctrl[base] = speed * np.cos(heading), speed * np.sin(heading), 0.3 * np.cos(phase)
        data.ctrl[arm] += 0.1 * np.cos(phase + np.arange(len(arm))) * PERIOD if tick else 0.0
        took = 0.0
        for _ in range(PARTS):
            # the hand goes along with the object, as a human who is led
            data.mocap_pos[:] = mocap + (front.xpos - first)
            data.ctrl[along] = hand.xmat.reshape(3, 3).T @ (front.xpos - before) * PARTS / PERIOD
            before = front.xpos.copy()
            begun = time.perf_counter()
            mujoco.mj_step(model, data, steps)
            took += time.perf_counter() - begun
        times.append(took)
        places.append((front.xpos + rear.xpos) / 2)
        deflection = max(deflection, np.linalg.norm(front.xpos - hand.xpos), np.linalg.norm(rear.xpos - grasp.xpos))
    assert np.isfinite(data.qpos).all()
    return float(np.median(times)), np.array(places), deflection


def measured(model: mujoco.MjModel, rates: tuple[int, ...], exact: np.ndarray) -> dict[int, tuple[float, float, float]]:
    """For every rate the time of a period (s), the error (m) and the deflection (m)."""
    found = {}
    for rate in rates:
        period, places, deflection = drive(model, 1 / rate)
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


def digits(value: float) -> float:
    return float(f"{value:.2e}")


def row(name: str, unit: str, value: float, peers: dict[str, float]) -> dict:
    """A row of `benches/rows/file.rs`, with the ratios of peers to its value."""
    against = [
        {"kind": "peer", "name": peer, "value": [digits(theirs)] * 2, "ratio": [digits(theirs / value)] * 2} for peer, theirs in peers.items()
    ]
    return {"bench": "mujoco_peer.py", "name": name, "unit": unit, "value": [digits(value)] * 2, "against": against, "measured": provenance()}


def provenance() -> dict:
    def git(*arguments: str) -> str:
        return subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True).stdout.strip()

    changes = git("status", "--porcelain", "--", ".", ":!benches/results.json", ":!book")
    return {
        "version": tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]["version"],
        "commit": git("rev-parse", "--short=8", "HEAD") + ("+" if changes else ""),
        "date": datetime.datetime.now(datetime.UTC).date().isoformat(),
        "cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
    }


def keep(rows: list[dict]) -> None:
    """Puts rows in place of the former ones of this script."""
    file = ROOT / "benches/results.json"
    kept = json.loads(file.read_text())["rows"] if file.exists() else []
    rows = [other for other in kept if other["bench"] != "mujoco_peer.py"] + rows
    rows.sort(key=lambda row: row["bench"])
    file.write_text(json.dumps({"rows": rows}, indent=2, ensure_ascii=False) + "\n")


def main() -> None:
    parser = argparse.ArgumentParser(description="The scene of benches/physics.rs in MuJoCo")
    parser.add_argument("--compare", action="store_true", help="and the plant of this repository, in turns")
    parser.add_argument("--rounds", type=int, default=3, help="how often; the fastest counts")
    parser.add_argument("--program", default=ROOT / "target/release/cocarry", help="whose `export` writes the scene")
    args = parser.parse_args()
    model = scene(args.program)
    exact = drive(model, 1 / FINE)[1]
    theirs, plant, whole, rate = {}, {}, 0.0, 0.0
    for _ in range(args.rounds):
        for key, found in measured(model, RATES, exact).items():
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
    period, error = plant[rate]
    name = f"MuJoCo {mujoco.__version__}"
    off = {f"{name}, {other} Hz": theirs[other][1] * 1e3 for other in (500, 1000, 2000)}
    keep([
        row(f"physics of a control period, {rate:.0f} Hz", "us", period * 1e6, {f"{name} at its usual 500 Hz": theirs[500][0] * 1e6}),
        row("a step of it", "us", period / PERIOD / rate * 1e6, {f"one of {name}": theirs[500][0] / PERIOD / 500 * 1e6}),
        row(f"how far off the object is, {rate:.0f} Hz", "mm", error * 1e3, off),
        row(f"a simulated second of a whole episode, {rate:.0f} Hz", "us", 1e6 / whole, {f"{name}'s physics alone, 500 Hz": 1e6 / usual}),
    ])


if __name__ == "__main__":
    main()
