"""Compares eqs. (7) and (8) of recorded episodes with their solutions by other means.

A recording gives q_c, q*, the candidates, s_o and P_o; B(q) follows from the URDF, and the solution from a
least-squares method. Not compared: half-planes of obstacles, and u with bodies, which depends on a guide of
the base that is not recorded. There only eq. (8) is compared, which takes the base's motion as given.
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import tomllib

import numpy as np
from mcap.reader import make_reader
from program import H, Program
from robot import Robot, difference

ROBOTS = pathlib.Path("assets/robots")
# of the rates, for a change of configuration (book: deviations, eq. (8)); an earlier candidate wins within TIE
SHARE_OF_BODIES, TIE = 0.25, 1e-9
EVERY = 4  # eq. (8) is compared in one step of so many: it takes 60 problems

KINEMATIC = ["--plant", "kinematic", "--no-obstacles", "--max-steps", 60]
HUMAN = ["--method", "human-led", "--preference-changes", 2]
EPISODES = [
    ["environment-4", *KINEMATIC, *HUMAN, "--seed", 1],
    ["environment-2", *KINEMATIC, *HUMAN, "--seed", 2, "--control-period", 0.1, "--pose", "whole-body"],
    ["environment-1", *KINEMATIC, "--robot", ROBOTS / "omni-carrier.toml", "--control-period", 0.05],
    ["environment-3", *KINEMATIC, *HUMAN, "--seed", 3, "--robot", ROBOTS / "porter.toml"],
    ["environment-2", *KINEMATIC, *HUMAN, "--robot", ROBOTS / "shuttle.toml", "--pose", "whole-body"],
    ["environment-1", *KINEMATIC, "--prepare-while-leading", "--speed", 1, "--yaw-rate", 2],
    ["environment-1", "--no-obstacles", "--max-steps", 30, *HUMAN, "--seed", 5],
]


# of every quantity, how large a difference may be, and the differences
FOUND = {}


def add(quantity, most, difference):
    FOUND.setdefault(quantity, (most, []))[1].append(float(difference))


def configuration(said):
    return np.array([said["x_m"], said["y_m"], said["yaw_rad"], *said["joints"]])


def present(step):
    """q at the beginning of a step."""
    said = step["/control"]
    joints = [joint.get("position_rad", joint.get("position_m")) for joint in said["joints"]]
    return np.array([said["base_x_m"], said["base_y_m"], np.radians(said["base_yaw_deg"]), *joints])


class Recording:
    def __init__(self, path):
        with open(path, "rb") as file:
            reader, self.steps = make_reader(file), {}
            scenario = tomllib.loads(next(reader.iter_attachments()).data.decode())
            for _, channel, message in reader.iter_messages(topics=["/control", "/preparation", "/options"]):
                said = json.loads(message.data)
                self.steps.setdefault(said["step"], {})[channel.topic] = said
        ((plant, parts),), settings = scenario["plant"].items(), scenario["settings"]
        setup, self.has_bodies = parts["robot"], plant == "rapier"
        self.control = control = setup["control"]
        self.robot = Robot(tomllib.loads(setup["robot"]["text"]), setup["robot"]["urdf"])
        self.period = settings.get("control_period_s", settings["period_s"])
        self.weights = control["state_weight"], control["input_weight"]

    def compare(self):
        """The last control period of every step."""
        for k, step in self.steps.items():
            said = step["/preparation"]
            target, candidates = configuration(said["target"]), said["candidates"]
            q_c = configuration(candidates[0]["q"]) if candidates else target
            references = [(np.reshape(r["s"], (H, 6)), r["weight"]) for r in said["references"]]
            tracked = step["/control"].get("tracked")
            given = {option["name"]: option.get("probability") for option in step["/options"]["options"]}
            for reference in said["references"] if tracked else []:
                add("weight of eq. (8) - P_o", 0, abs(reference["weight"] - given[reference["name"]]))
            if candidates:
                named = configuration(candidates[step["/control"]["pose_candidate"]]["q"])
                add("q* - the candidate named", 0, np.abs(named - target).max())
            if not self.has_bodies and k + 1 in self.steps:
                followed = [r["name"] for r in said["references"]].index(tracked) if tracked else 0
                self.compare_inputs(q_c, target, references[followed][0], present(self.steps[k + 1]))
            if k % EVERY == 0 and len(candidates) > 1:
                self.compare_choice(q_c, target, candidates, references)

    def compare_inputs(self, q_c, target, s, reached):
        """Eq. (7), on the kinematic plant, which moves exactly as u says."""
        taken = self.robot.inputs_between(q_c, target, self.period)
        program = Program(self.robot, self.period * self.robot.kinematics(target)[1], self.weights)
        u, _, is_limited = program.solve(s, target[3:], taken, self.period)
        moved = self.robot.inputs_between(target, reached, self.period)
        add(f"u, limits {'' if is_limited else 'not '}active", 1e-9, np.abs(u[0] - moved).max())

    def compare_choice(self, q_c, target, candidates, references):
        """Eq. (8): the candidates, their sums, and that q* has the least."""
        robot, period, totals = self.robot, self.period, []
        grasp, share = robot.kinematics(q_c)[0], SHARE_OF_BODIES if self.has_bodies else 1.0
        for said in candidates:
            q = configuration(said["q"])
            there, jacobian = robot.kinematics(q)
            add("candidate's grasp", 1e-6, np.linalg.norm(difference(there, grasp)))
            taken = robot.inputs_between(q_c, q, period)
            over = [np.abs(taken) - share * robot.rates, robot.lower - q[3:], q[3:] - robot.upper]
            add("candidate beyond a limit", 1e-9, max(0, np.concatenate(over).max()))
            if self.has_bodies:
                jacobian[:, : robot.base] = 0
            program = Program(robot, period * jacobian, self.weights)
            motion = np.append(q[3:] - q_c[3:], taken[: robot.base])
            total = bound = self.control["pose_weight"] * motion @ motion
            for s, weight in references:
                if weight > 0:
                    bound += weight * program.unlimited(s)[1]
                    total += weight * program.solve(s, q[3:], taken, period)[1]
            add("sum of eq. (8) without limits", 1e-11, abs(said["lower_bound"] / bound - 1))
            if "total" in said:
                add("sum of eq. (8)", 1e-11, abs(said["total"] / total - 1))
            totals.append(total)
        best = next(i for i, total in enumerate(totals) if total <= min(totals) + TIE)
        add("q* - the best candidate", 0, np.abs(configuration(candidates[best]["q"]) - target).max())


def main():
    with tempfile.TemporaryDirectory() as folder:
        for arguments in EPISODES:
            path = pathlib.Path(folder) / "run.mcap"
            command = [sys.argv[1], "run", *arguments, "--record", path, "--overwrite"]
            # 3: the episode ends before the target, as it should
            assert subprocess.run(list(map(str, command)), capture_output=True).returncode in (0, 3), command
            Recording(path).compare()
    for quantity, (most, values) in sorted(FOUND.items()):
        rms, verdict = np.sqrt(np.mean(np.square(values))), "" if max(values) <= most else f"  ABOVE {most:g}"
        print(f"{quantity:30} {len(values):5}   max {max(values):.1e}   rms {rms:.1e}{verdict}")
    sys.exit(any(max(values) > most for most, values in FOUND.values()))


main()
