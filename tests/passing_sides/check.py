"""Compares python/examples/passing_sides with the authors' code, which runs beside it, on random states.

The learned planner is compared with the weights of their repository, which ours does not have, and equal noise.

Their nodes are written for ROS 2, which is not needed here: their modules find empty classes in its place, and only
their cost functions are called. These work in single precision; they are compared once as they are, and once with
double precision in its place, where only rounding is left.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib.abc
import importlib.machinery
import io
import logging
import math
import os
import pathlib
import sys
import types
from typing import Any
from unittest import mock

import numpy as np

STATES = 10_000
ROLLOUTS = 100
PREDICTIONS = 50
#: Modules of ROS 2.
ROS = ("builtin_interfaces", "geometry_msgs", "nav_msgs", "rclpy", "sensor_msgs", "std_msgs", "tf2_msgs", "tf2_ros", "visualization_msgs")


def empty(name: str) -> type:
    if name.startswith("__"):
        raise AttributeError(name)
    return type(name, (), {})


class EmptyRos(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Modules of ROS 2 in which every name is an empty class."""

    def find_spec(self, name: str, path: Any, target: Any = None) -> importlib.machinery.ModuleSpec | None:
        if name.split(".")[0] not in ROS:
            return None
        return importlib.machinery.ModuleSpec(name, self, is_package=True)

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> types.ModuleType:
        module = types.ModuleType(spec.name)
        module.__path__ = []
        module.__getattr__ = empty  # type: ignore[method-assign]
        return module

    def exec_module(self, module: types.ModuleType) -> None:
        pass


if len(sys.argv) != 2:
    sys.exit(f"usage: {sys.argv[0]} FOLDER, that of icmpc_collab_transport")
theirs = pathlib.Path(sys.argv[1]) / "src"
if not (theirs / "fluentrobotics" / "icmpc_collab_transport").is_dir():
    sys.exit(f"{theirs}: no fluentrobotics/icmpc_collab_transport in it; give the folder of their repository")
planner = theirs / "eleyng" / "table-carrying-ai"
sys.path[:0] = [str(theirs), str(planner), str(pathlib.Path(__file__).parents[2] / "python" / "examples" / "passing_sides")]
sys.meta_path.append(EmptyRos())

import torch  # noqa: E402
import pytorch_mppi  # noqa: E402
from fluentrobotics.icmpc_collab_transport.core import passing_inference as their_inference  # noqa: E402
from fluentrobotics.icmpc_collab_transport.core.se2_types import Transform, Velocity  # noqa: E402
from fluentrobotics.icmpc_collab_transport.core.strategy import PassingStrategy  # noqa: E402
from fluentrobotics.icmpc_collab_transport.deployment.diff_drive_kinematics import kinematics  # noqa: E402
from fluentrobotics.icmpc_collab_transport.deployment.icmpc_node import IcmpcNode  # noqa: E402
from fluentrobotics.icmpc_collab_transport.deployment.vanilla_mpc_node import VanillaMpcNode  # noqa: E402
from fluentrobotics.icmpc_collab_transport.deployment import vrnn_node  # noqa: E402
from cooperative_transport.custom_rewards import custom_reward_function  # noqa: E402
from cooperative_transport.planner_utils import tf2model, tf2sim  # noqa: E402

import learned_network  # noqa: E402
import learned_planner as learned  # noqa: E402
import passing_inference as inference  # noqa: E402
import sampling_mpc as control  # noqa: E402

# their network is small: threads cost more than they give
torch.set_num_threads(1)
# it says that the checkpoint is of an older version
logging.getLogger("pytorch_lightning").setLevel(logging.ERROR)

OBSTACLE, GOAL = np.array([0.5, 0.0]), np.array([0.5, -2.5])
SIDES = (PassingStrategy.LEFT, PassingStrategy.RIGHT)
failures = 0


def report(what: str, count: int, largest: float, tolerance: float) -> None:
    global failures
    failures += not largest <= tolerance
    print(f"{what:62} {count:7}  {largest:8.1e}  {tolerance:.0e}  {'ok' if largest <= tolerance else 'DIFFERS'}")


def updated(library: Any, plan: Any, last: Any, noise: Any, pose: Any) -> Any:
    """The plan of their library after an update from a plan, the last inputs and a pose, with this noise in place of its own."""
    library.U, library.u_init = torch.tensor(plan), torch.tensor(last)
    library.noise_dist = types.SimpleNamespace(rsample=lambda shape: torch.tensor(noise))
    library.command(torch.tensor(pose))
    return library.U


def difference(ours: Any, other: Any) -> float:
    return float(np.max(np.abs(np.asarray(ours, float) - np.asarray(other, float))))


print(f"{'':62} {'numbers':>7}  {'largest':>8}  bound")
generator = np.random.default_rng(0)


def transform(position: Any) -> Transform:
    return Transform(float(position[0]), float(position[1]))


# 1. inference: half of the states in their room, half with any obstacle and goal
positions = generator.uniform([-0.86, -2.85], [1.92, 2.71], (STATES, 2))
obstacles, goals = np.tile(OBSTACLE, (STATES, 1)), np.tile(GOAL, (STATES, 1))
half = STATES // 2
obstacles[half:], goals[half:] = generator.uniform(-3, 3, (2, half, 2))
human, robot = generator.normal(0.0, 0.3, (2, STATES, 2))
priors, likelihoods, posteriors, entropies, actions = [], [], [], [], []
for i in range(STATES):
    at = (transform(obstacles[i]), transform(goals[i]), transform(positions[i]))
    prior = their_inference.PriorDistribution(*at)
    likelihood = their_inference.ActionLikelihoodDistribution(*at)
    velocities = [Velocity(float(v[0]), float(v[1])) for v in (human[i], robot[i])]
    posterior = their_inference.PosteriorDistribution(prior, likelihood, *velocities)
    priors.append([prior.pmf[side] for side in SIDES])
    likelihoods.append(likelihood.pmf[1:])
    posteriors.append([posterior.pmf[side] for side in SIDES])
    entropies.append(posterior.get_entropy())
    actions.append(posterior._discretize_action(velocities[0]))
ours = inference.side_posterior(obstacles, goals, positions, human, robot)
report("prior of the sides", 2 * STATES, difference(inference.side_prior(obstacles, goals, positions), priors), 1e-12)
report("likelihood of 9 actions given the side", 18 * STATES, difference(inference.action_likelihood(obstacles, goals, positions), likelihoods), 1e-12)
report("action of a velocity", STATES, difference(inference.action_of(human), actions), 0)
report("posterior of the sides", 2 * STATES, difference(ours, posteriors), 1e-12)
report("entropy of the posterior, bit", STATES, difference(inference.entropy(ours), entropies), 1e-12)

# 2. cost terms and the unicycle, in their precision and in double precision
poses = np.column_stack([positions, generator.uniform(-math.pi, math.pi, STATES)])
inputs = generator.uniform([0.0, -1.0], [0.3, 1.0], (STATES, 2))
inputs[::10, 1] = 0.0
base_to_object, human_velocity = np.array([0.1, -0.8]), np.array([0.05, -0.25])
clearance = control.clearance_cost(poses[:, :2], OBSTACLE)
uncertainty = control.uncertainty_cost(poses, base_to_object, OBSTACLE, GOAL, human_velocity)
goal = control.goal_cost(poses[:, :2], GOAL)
for name, precision, tolerance in (("single", torch.float32, 2e-5), ("double", torch.float64, 1e-12)):
    with mock.patch.object(torch, "float32", precision):

        def node(kind: type) -> Any:
            made = object.__new__(kind)
            made.obstacle, made.goal = transform(OBSTACLE), transform(GOAL)
            made.obstacle_tensor, made.goal_tensor = torch.tensor(OBSTACLE, dtype=precision), torch.tensor(GOAL, dtype=precision)
            made.tf_map_R, made.tf_R_obj = Transform(), transform(base_to_object)
            made.v_map_H = Velocity(*map(float, human_velocity))
            return made

        vanilla, implicit = node(VanillaMpcNode), node(IcmpcNode)
        s, a = torch.tensor(poses, dtype=precision), torch.tensor(inputs, dtype=precision)
        report(f"cost of clearance, {name} precision", STATES, difference(clearance, vanilla.cost(s, a)), tolerance)
        report(f"cost of clearance and entropy, {name} precision", STATES, difference(clearance + uncertainty, implicit.cost(s, a)), tolerance)
        final = vanilla.terminal_state_cost(s[None, :, None], a[None, :, None])
        report(f"cost at the end of the horizon, {name} precision", STATES, difference(goal, final), tolerance)
        moved = np.asarray(kinematics(s, a), float)
        ahead = control.unicycle(poses, inputs, 0.25)
        turn = np.abs(np.exp(1j * moved[:, 2]) - np.exp(1j * ahead[:, 2]))
        report(f"unicycle, {name} precision", 3 * STATES, max(difference(ahead[:, :2], moved[:, :2]), float(turn.max())), tolerance)

# 3. whole updates of the MPPI library with their cost, from the same plan, noise and pose
largest = 0.0
with mock.patch.object(torch, "float32", torch.float64):
    implicit = node(IcmpcNode)
    sigma = torch.diag(torch.tensor([0.25, 1.0], dtype=torch.float64))
    bounds = {"u_min": torch.tensor([0.0, -1.0], dtype=torch.float64), "u_max": torch.tensor([0.3, 1.0], dtype=torch.float64)}
    library = pytorch_mppi.MPPI(kinematics, implicit.cost, 3, sigma, num_samples=100, terminal_state_cost=implicit.terminal_state_cost, **bounds)
    mppi = control.Mppi(seed=0)
    for i in range(ROLLOUTS):
        plan = generator.normal(0.0, 0.3, (mppi.horizon, 2))
        last = generator.uniform([0.0, -1.0], [0.3, 1.0])
        noise = generator.normal(0.0, [0.5, 1.0], (mppi.samples, mppi.horizon, 2))
        theirs = updated(library, plan, last, noise, poses[i])
        ours = mppi.improved(
            np.concatenate([plan[1:], last[np.newaxis]]),
            noise,
            poses[i],
            lambda at: control.clearance_cost(at[:, :2], OBSTACLE) + control.uncertainty_cost(at, base_to_object, OBSTACLE, GOAL, human_velocity),
            lambda at: control.goal_cost(at[:, :2], GOAL),
        )
        largest = max(largest, difference(ours, theirs))
report("plan after an MPPI update of 100 samples, double precision", ROLLOUTS * 30, largest, 1e-12)

# 4. the learned planner, with their weights and the same noise: histories of a walk in their room at 15 Hz
checkpoint = planner / "model.ckpt"
network = learned_network.Vrnn.read(checkpoint)
print(f"their network: {sum(value.size for value in network.parameters.values())} parameters, {network.observed} steps observed")


def ours_of(points: Any) -> np.ndarray:
    """Points (..., 2) of their room, m, in the frame of ours."""
    points = np.asarray(points, float)
    return np.stack([-points[..., 1], points[..., 0] - OBSTACLE[0]], axis=-1)


def walk() -> np.ndarray:
    """Poses (40, 3) of the object in their frame: x, y (m), heading (rad)."""
    speeds = np.cumsum(generator.normal(0.0, 0.02, (40, 3)), axis=0) + generator.normal([0.0, -0.25, 0.0], [0.1, 0.1, 0.2])
    start = generator.uniform([-0.86, -2.85, -math.pi], [1.92, 2.71, math.pi])
    return np.asarray(start + np.cumsum(speeds, axis=0) / learned.RATE_HZ)


walks = [walk() for _ in range(PREDICTIONS)]
# the first one stands still and has one state: their history is filled with it
walks[0] = walks[0][:1]
noises = generator.standard_normal((PREDICTIONS, learned.CANDIDATES, learned.SEQUENCE, network.latents))
obstacle_px, goal_px = learned.ROOM.to_window([ours_of(OBSTACLE)]), learned.ROOM.to_window(ours_of(GOAL))
# of the features, of whole sequences, of scores, of the best way in the room; single precision is theirs as it is
allowed = {"single": (5e-4, 0.5, 5e-2, 1e-2), "double": (1e-11, 1e-9, 1e-10, 1e-11)}
for name, precision in (("single", torch.float32), ("double", torch.float64)):
    with contextlib.ExitStack() as stack:
        stack.enter_context(mock.patch.object(torch, "float32", precision))
        if name == "double":
            stack.enter_context(mock.patch.object(np, "float32", np.float64))
        stack.callback(torch.set_default_dtype, torch.get_default_dtype())
        torch.set_default_dtype(precision)
        stack.callback(os.chdir, os.getcwd())
        os.chdir(theirs.parent)
        with contextlib.redirect_stdout(io.StringIO()), torch.serialization.safe_globals([argparse.Namespace]):
            wrapper = vrnn_node.VRNNWrapper(transform(GOAL), [transform(OBSTACLE)])
        wrapper.model.to(precision)
        differences = np.zeros(4)
        same = 0
        for walked, noise in zip(walks, noises):
            wrapper.state_history.clear()
            for pose in walked:
                wrapper.add_state(Transform(*map(float, pose)))
            states = torch.vstack(tuple(wrapper.state_history))
            recent = np.concatenate([np.tile(walked[:1], (max(0, 31 - len(walked)), 1)), walked])[-31:]
            history = np.column_stack([learned.ROOM.to_window(ours_of(recent[:, :2])), recent[:, 2] + math.pi])

            features = learned.network_features(history, obstacle_px, goal_px)
            differences[0] = max(differences[0], difference(features, tf2model(states, wrapper.obstacles)))

            def drawn(like: Any, noise: Any = noise, step: Any = iter(range(learned.SEQUENCE)), **_: Any) -> Any:
                return torch.tensor(noise[:, next(step)], dtype=precision).reshape(like.shape)

            with mock.patch.object(torch, "randn_like", drawn), torch.no_grad():
                history_inputs = tf2model(states, wrapper.obstacles).repeat(wrapper.BSIZE, 1, 1)
                samples = wrapper.model.sample(history_inputs, seq_len=wrapper.SEQ_LEN)
            sequences = network.sample(features, noise)
            differences[1] = max(differences[1], difference(sequences, samples))

            their_ways = tf2sim(samples, states, wrapper.H)
            ways = learned.predicted_ways(network, history, obstacle_px, goal_px, noise)
            arguments = (wrapper.goal.numpy(), wrapper.obstacles.numpy())
            scores = [custom_reward_function(way.numpy(), *arguments, vectorized=True).sum() for way in their_ways]
            our_scores = learned.score(ways, obstacle_px, goal_px)
            differences[2] = max(differences[2], difference(our_scores, scores))
            same += int(our_scores.argmax() == np.argmax(scores))

            with mock.patch.object(torch, "randn_like", lambda like, step=iter(range(learned.SEQUENCE)), **_: drawn(like, step=step)):
                rollout, _ = wrapper.get_nominal_rollout()
            best = learned.ROOM.from_window(ways[int(np.argmax(scores))])
            differences[3] = max(differences[3], difference(best, ours_of(rollout.numpy()[:, :2])))
        steps = learned.CANDIDATES * learned.SEQUENCE
        for what, count, found, bound in zip(
            (
                "features of the history",
                "sequences of the network",
                "scores of the predictions",
                "best prediction in the room, m",
            ),
            (30 * 8, steps * 8, learned.CANDIDATES, (learned.SEQUENCE - learned.HISTORY) * 2),
            differences,
            allowed[name],
        ):
            report(f"{what}, {name} precision", PREDICTIONS * count, float(found), bound)
        if name == "double":
            report("index of the best prediction, double precision", PREDICTIONS, float(PREDICTIONS - same), 0)

# 5. whole updates of the MPPI library with the learned planner's cost
largest = 0.0
with mock.patch.object(torch, "float32", torch.float64):
    follower = object.__new__(vrnn_node.VrnnNode)
    follower.tf_R_obj = transform(base_to_object)
    costs = {"terminal_state_cost": follower.terminal_state_cost, **bounds}
    library = pytorch_mppi.MPPI(kinematics, follower.cost, 3, sigma, num_samples=100, **costs)
    for i in range(ROLLOUTS):
        carried = control.carried_position(poses[i], base_to_object)
        way = carried + np.cumsum(generator.normal(0.0, 0.03, (90, 2)), axis=0)
        follower.vrnn_prediction = torch.tensor(np.column_stack([way, np.full(90, poses[i, 2])]))
        plan = generator.normal(0.0, 0.3, (mppi.horizon, 2))
        last = generator.uniform([0.0, -1.0], [0.3, 1.0])
        noise = generator.normal(0.0, [0.5, 1.0], (mppi.samples, mppi.horizon, 2))
        theirs = updated(library, plan, last, noise, poses[i])
        waypoints = (way - carried + poses[i, :2])[:: learned.WAYPOINT_STRIDE][: mppi.horizon]
        ours = mppi.improved(
            np.concatenate([plan[1:], last[np.newaxis]]),
            noise,
            poses[i],
            lambda at, waypoints=waypoints: learned.horizon_cost(at, waypoints),
            lambda at: np.zeros(len(at)),
        )
        largest = max(largest, difference(ours, theirs))
report("plan after an MPPI update that follows a prediction", ROLLOUTS * 30, largest, 1e-12)

# 6. where the learned planner leads alone: the object follows the best prediction exactly, from 2.5 m before the post
print("\nthe best prediction, followed exactly: least distance of the object's centre from the post's and from the goal, m")
post, goal = np.zeros(2), ours_of(GOAL)
for formation, heading in (("side by side, as theirs", math.pi / 2), ("in tandem, as ours", math.pi)):
    for aside in (-0.3, 0.0, 0.3):
        history = np.tile([*learned.ROOM.to_window((-2.5, aside)), heading], (learned.HISTORY + 1, 1))
        passed: list[Any] = []
        while len(passed) < 100 and history[-1, 0] < learned.WINDOW_PX[0]:
            noise = generator.standard_normal((learned.CANDIDATES, learned.SEQUENCE, network.latents))
            ways = learned.predicted_ways(network, history, obstacle_px, goal_px, noise)
            steps_px = ways[learned.score(ways, obstacle_px, goal_px).argmax(), :3]
            history = np.concatenate([history, np.column_stack([steps_px, np.full(3, heading)])])[-learned.HISTORY - 1 :]
            passed.append(learned.ROOM.from_window(steps_px[-1]))
        nearest = [float(np.hypot(*(np.array(passed) - point).T).min()) for point in (post, goal)]
        print(f"{formation:24} from {aside:+.1f} m aside: {nearest[0]:.2f} {nearest[1]:.2f}")
sys.exit(failures > 0)
