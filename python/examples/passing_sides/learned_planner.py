"""The third policy of the passing-side paper: a learned planner (VRNN), whose prediction sampling MPC follows.

A network that learned from two people who carry a table in a window of 1200 by 600 pixels, from above, predicts where
the object goes; the best of 16 predictions is what the robot's end of the object follows. The network is that of
"It Takes Two: Learning to Plan for Human-Robot Cooperative Carrying", ICRA 2023 (arXiv:2209.12890); how the passing-side
paper (HRI 2025, arXiv:2502.03346) uses it is from its public code (fluentrobotics/icmpc_collab_transport). This is an
implementation of its own. The weights are not part of it: the user names their file.

The pixel (0, 0) is the floor's left corner at the start; x is ahead and y to the right. A heading is that from the
object's centre to the robot, rad, counter-clockwise seen from above, although y is to the right: so did the network
learn it.

What their code does, and this repeats:

- The network observes the oldest 6 of the 30 steps of the history, by the hyperparameters of its checkpoint (30 // 5).
- It learned steps of 5 frames of 1/30 s; here a step is 1/15 s.
- The score's walls are at x = 600 and y = 1200, the window's size with its sides swapped: `SCORE_WALLS_PX`. The
  window of the network's authors has them at x = 1200 and y = 600.
- The object keeps its heading in the prediction.

Departures from their robot are those of `passing_policies`. The policy decides every 0.2 s; the history has three states
in that time, between which the object moves evenly.
"""

from __future__ import annotations

import math
import pathlib
import pickle
from dataclasses import dataclass

import cocarry
import numpy as np
from numpy.typing import ArrayLike

from learned_network import Vrnn
from passing_inference import Floats
from passing_policies import VanillaMpc
from scenes import Scene

#: Size of the window, x and y, pixels (code).
WINDOW_PX = (1200.0, 600.0)
#: Where the score has a wall besides those at 0, x and y, pixels (code).
SCORE_WALLS_PX = (600.0, 1200.0)
#: Lengths in the score, of the goal and of obstacles and walls, pixels (code).
GOAL_LENGTH_PX, OBSTACLE_LENGTH_PX = 300.0, 50.0
#: What goal and obstacle are divided by in the features (code).
FEATURE_SCALE = 8.0
#: Steps of the history, of history and prediction, and number of predictions (code).
HISTORY, SEQUENCE, CANDIDATES = 30, 120, 16
#: States of the history per second, Hz (code).
RATE_HZ = 15.0
#: The MPC's cost of step i is the distance from waypoint WAYPOINT_STRIDE * i, times DISCOUNT ** i (code).
WAYPOINT_STRIDE, DISCOUNT = 3, 0.95


@dataclass(frozen=True)
class Floor:
    """The rectangle of the floor that is the window: from and to, in x and y, m, where the team walks along x."""

    x_m: tuple[float, float]
    y_m: tuple[float, float]

    def to_window(self, points: ArrayLike) -> Floats:
        """The pixels (..., 2) of points (..., 2), m."""
        points = np.asarray(points, float)
        x, y = points[..., 0] - self.x_m[0], self.y_m[1] - points[..., 1]
        return np.stack([x, y], axis=-1) * self._pixels_per_m

    def from_window(self, pixels: ArrayLike) -> Floats:
        """The points (..., 2), m, of pixels (..., 2)."""
        offset = np.asarray(pixels, float) / self._pixels_per_m
        return np.stack([self.x_m[0] + offset[..., 0], self.y_m[1] - offset[..., 1]], axis=-1)

    @property
    def _pixels_per_m(self) -> Floats:
        return np.array(WINDOW_PX) / (self.x_m[1] - self.x_m[0], self.y_m[1] - self.y_m[0])


#: The floor of the paper's room, in the frame of `room.toml`.
ROOM = Floor((-2.71, 2.85), (-1.36, 1.42))


def network_features(history: Floats, obstacles: Floats, goal: Floats) -> Floats:
    """The network's inputs (n, 8), of a history (n + 1, 3) of x, y (pixels) and heading (rad).

    The steps of x, y, cosine and sine, and the goal (2,) and the nearest of obstacles (m, 2), pixels, as seen from where
    a step begins, over FEATURE_SCALE.
    """
    state = np.stack([history[:, 0], history[:, 1], np.cos(history[:, 2]), np.sin(history[:, 2])], axis=-1)
    start = state[:-1]
    offsets = obstacles - start[:, np.newaxis, :2]
    nearest = offsets[np.arange(len(start)), np.hypot(offsets[..., 0], offsets[..., 1]).argmin(axis=1)]
    seen = [np.diff(state, axis=0)]
    for offset in (goal - start[:, :2], nearest):
        ahead = start[:, 2] * offset[:, 0] + start[:, 3] * offset[:, 1]
        aside = start[:, 2] * offset[:, 1] - start[:, 3] * offset[:, 0]
        seen.append(np.stack([ahead, aside], axis=-1) / FEATURE_SCALE)
    return np.concatenate(seen, axis=-1)


def score(waypoints: Floats, obstacles: Floats, goal: Floats, walls: tuple[float, float] = SCORE_WALLS_PX) -> Floats:
    """The scores (...) of ways (..., n, 2), pixels: the sum over their waypoints of

        -0.1 + exp(-d_g^2 / (2 GOAL_LENGTH_PX^2)) - sum over obstacles and four walls of exp(-d^2 / (2 OBSTACLE_LENGTH_PX^2))

    with the distances from the goal (2,), from obstacles (m, 2) and from the walls at x and y of 0 and `walls`, pixels.
    """

    def near(squared: Floats, length: float) -> Floats:
        return np.asarray(np.exp(-squared / (2.0 * length**2)))

    found = near(np.sum((waypoints - goal) ** 2, axis=-1), GOAL_LENGTH_PX) - 0.1
    for obstacle in obstacles:
        found = found - near(np.sum((waypoints - obstacle) ** 2, axis=-1), OBSTACLE_LENGTH_PX)
    for wall in (np.zeros(2), np.array(walls)):
        found = found - near((waypoints - wall) ** 2, OBSTACLE_LENGTH_PX).sum(axis=-1)
    return np.asarray(found.sum(axis=-1))


def predicted_ways(network: Vrnn, history: Floats, obstacles: Floats, goal: Floats, noise: Floats) -> Floats:
    """Predicted ways (CANDIDATES, SEQUENCE - HISTORY, 2), pixels, from where a history (HISTORY + 1, 3) ends.

    noise: standard normal, (CANDIDATES, SEQUENCE, latents); sizes may be others.
    """
    steps = network.sample(network_features(history, obstacles, goal), noise)[:, len(history) - 1 :, :2]
    return np.asarray(history[-1, :2] + np.cumsum(steps, axis=1))


def tracking_cost(positions: Floats, waypoint: Floats, step: int) -> Floats:
    """The MPC's cost (n,) of positions (n, 2), m, at a step of its horizon: discounted distance from a waypoint (2,), m."""
    offset = positions - waypoint
    return np.asarray(DISCOUNT**step * np.hypot(offset[:, 0], offset[:, 1]))


def horizon_cost(poses: Floats, waypoints: Floats) -> Floats:
    """The costs (steps * samples,) of following waypoints (steps, 2), m, for poses (steps * samples, 3), step by step."""
    steps = poses.reshape(len(waypoints), -1, poses.shape[-1])
    return np.concatenate([tracking_cost(at[:, :2], waypoint, i) for i, (at, waypoint) in enumerate(zip(steps, waypoints))])


class LearnedPlanner(VanillaMpc):
    """The learned planner: sampling MPC that follows the best of the network's predictions.

    network: with its weights, as `Vrnn.read` takes them from a checkpoint; or that file.
    scene: the obstacle and the goal.
    seed: of the MPC's samples and of the latents.
    floor: what the window of the network is.
    score_walls: walls of the score, pixels.
    heading: the heading in the window of an object whose yaw to the hand is 0, rad. By default it is pi, that to the
        robot; with pi / 2, the network sees a team that carries side by side, as the paper's does.
    """

    name = "learned"

    def __init__(
        self,
        network: Vrnn | str | pathlib.Path,
        scene: Scene,
        seed: int = 0,
        floor: Floor = ROOM,
        score_walls: tuple[float, float] = SCORE_WALLS_PX,
        heading: float = math.pi,
    ) -> None:
        super().__init__(scene, seed)
        self.network = network if isinstance(network, Vrnn) else Vrnn.read(network)
        self.floor, self.score_walls, self.turn = floor, score_walls, heading
        self.generator = np.random.default_rng([seed, 1])
        #: The object's poses, x, y (m) and yaw to the hand (rad), of the last steps, and the time of the last one, s.
        self.history = np.empty((0, 3))
        self.history_time_s = math.nan

    def decide(self, view: cocarry.RobotView) -> cocarry.Decision | None:
        """Who leads, and the reference of the grasp for the next planning steps."""
        if view.object is not None:
            yaw = math.atan2(view.object[1, 0], view.object[0, 0])
            self._remember(view.time_s, np.array([view.object[0, 3], view.object[1, 3], yaw]))
        return super().decide(view)

    def _remember(self, time_s: float, pose: Floats) -> None:
        """Adds the poses (3,) until a time to the history; the first one fills it."""
        if len(self.history) == 0:
            self.history = np.tile(pose, (HISTORY + 1, 1))
        elif time_s > self.history_time_s:
            change = pose - self.history[-1]
            change[2] = math.remainder(change[2], 2.0 * math.pi)
            count = max(1, round((time_s - self.history_time_s) * RATE_HZ))
            share = np.arange(1, count + 1)[:, np.newaxis] / count
            self.history = np.concatenate([self.history, self.history[-1] + share * change])[-HISTORY - 1 :]
        self.history_time_s = time_s

    def _prediction(self, obstacle: Floats, goal: Floats) -> Floats:
        """The best predicted way of the object's centre, (SEQUENCE - HISTORY, 2), m."""
        history = np.column_stack([self.floor.to_window(self.history[:, :2]), self.history[:, 2] + self.turn])
        obstacles, end = self.floor.to_window([obstacle]), self.floor.to_window(goal)
        noise = self.generator.standard_normal((CANDIDATES, SEQUENCE, self.network.latents))
        ways = predicted_ways(self.network, history, obstacles, end, noise)
        best = int(score(ways, obstacles, end, self.score_walls).argmax())
        return self.floor.from_window(ways[best])

    def _improve(
        self, pose: Floats, inputs: tuple[float, float], held: Floats, obstacle: Floats, goal: Floats, human_velocity: Floats
    ) -> None:
        """Improves the plan: robot's end and object move as the object does in the prediction."""
        way = self._prediction(obstacle, goal) - self.history[-1, :2] + pose[:2]
        waypoints = way[::WAYPOINT_STRIDE][: self.mppi.horizon]
        self.mppi.command(pose, inputs, lambda poses: horizon_cost(poses, waypoints), lambda poses: np.zeros(len(poses)))

    def save(self) -> bytes:
        """What vanilla MPC saves, the history, and the generator of the latents."""
        own = self.history, self.history_time_s, self.generator.bit_generator.state
        return pickle.dumps((super().save(), own))

    def restore(self, state: bytes) -> None:
        """Restores what `save` returned."""
        base, (self.history, self.history_time_s, generator) = pickle.loads(state)
        super().restore(base)
        self.generator.bit_generator.state = generator
