"""Sampling-based model predictive control of a differential base: model predictive path integral control (MPPI).

The update is Algorithm 2 of G. Williams et al., "Information Theoretic MPC for Model-Based Reinforcement Learning",
ICRA 2017. The parameters are those of the passing-side paper (HRI 2025, arXiv:2502.03346) and its public code; its
library's defaults where it names none.

A state is a pose of the base on the floor: x, y (m) and yaw (rad). Inputs are the speed ahead (m/s) and the turning
rate (rad/s).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from passing_inference import Floats, entropy, side_posterior

#: Distance from the obstacle's centre below which the base pays, m (code).
CLEARANCE_M = 0.5


def unicycle(pose: ArrayLike, inputs: ArrayLike, period: float) -> Floats:
    """The poses (..., 3) after constant inputs (..., 2) for a period (s): exact arcs, yaw from -pi to pi."""
    pose, inputs = np.asarray(pose, float), np.asarray(inputs, float)
    speed, rate = inputs[..., 0], inputs[..., 1]
    turn = rate * period
    turns = turn != 0.0
    radius = speed / np.where(turns, rate, 1.0)
    ahead = np.where(turns, radius * np.sin(turn), speed * period)
    left = np.where(turns, radius * (1.0 - np.cos(turn)), 0.0)
    cosine, sine = np.cos(pose[..., 2]), np.sin(pose[..., 2])
    yaw = pose[..., 2] + turn
    moved = (ahead * cosine - left * sine, ahead * sine + left * cosine)
    return np.stack([pose[..., 0] + moved[0], pose[..., 1] + moved[1], np.arctan2(np.sin(yaw), np.cos(yaw))], axis=-1)


def clearance_cost(position: ArrayLike, obstacle: ArrayLike) -> Floats:
    """Cost of being near an obstacle's centre: max(0, -log2(distance / CLEARANCE_M)), of positions (..., 2), m."""
    offset = np.asarray(position, float) - obstacle
    distance = np.hypot(offset[..., 0], offset[..., 1])
    return np.asarray(np.maximum(-np.log2(distance / CLEARANCE_M), 0.0))


def goal_cost(position: ArrayLike, goal: ArrayLike) -> Floats:
    """Cost at the end of the horizon: squared distance from the goal, m^2, of positions (..., 2), m."""
    return np.asarray(np.sum((np.asarray(position, float) - goal) ** 2, axis=-1))


def carried_position(pose: ArrayLike, base_to_object: ArrayLike) -> Floats:
    """The object's centre (..., 2), m, in the world, of a base at poses (..., 3) that holds it at (2,), m, in its own frame."""
    pose = np.asarray(pose, float)
    ahead, left = np.asarray(base_to_object, float)
    cosine, sine = np.cos(pose[..., 2]), np.sin(pose[..., 2])
    return np.stack([pose[..., 0] + ahead * cosine - left * sine, pose[..., 1] + ahead * sine + left * cosine], axis=-1)


def uncertainty_cost(
    pose: ArrayLike, base_to_object: ArrayLike, obstacle: ArrayLike, goal: ArrayLike, human_velocity: ArrayLike
) -> Floats:
    """Entropy (bit) of the side, as the human would infer it, at poses of the base (..., 3).

    The object moves rigidly with the base, the human keeps their velocity (2,), m/s, and the robot's action is the
    direction in which its base faces.
    """
    pose = np.asarray(pose, float)
    facing = np.stack([np.cos(pose[..., 2]), np.sin(pose[..., 2])], axis=-1)
    return entropy(side_posterior(obstacle, goal, carried_position(pose, base_to_object), human_velocity, facing))


@dataclass
class Mppi:
    """MPPI: the inputs of a horizon, improved by the mean of random ones, weighted by what they cost.

    Deterministic: the same seed and the same calls give the same inputs.
    """

    seed: int
    #: Sampled sequences of inputs (code), steps of the horizon (library), and the length of a step, s (code).
    samples: int = 100
    horizon: int = 15
    period: float = 0.25
    #: The temperature lambda (library).
    temperature: float = 1.0
    #: Variances of speed and turning rate, (m/s)^2 and (rad/s)^2 (code).
    variance: tuple[float, float] = (0.25, 1.0)
    #: Limits of speed (m/s) and turning rate (rad/s) (code).
    lower: tuple[float, float] = (0.0, -1.0)
    upper: tuple[float, float] = (0.3, 1.0)
    #: The sequence of inputs that the next call starts from, (horizon, 2).
    plan: Floats = field(init=False)

    def __post_init__(self) -> None:
        self.generator = np.random.default_rng(self.seed)
        self.plan = self._noise(self.horizon)

    def command(
        self,
        pose: ArrayLike,
        last_inputs: ArrayLike,
        running_cost: Callable[[Floats], Floats],
        final_cost: Callable[[Floats], Floats],
    ) -> Floats:
        """The inputs (2,) for now, at a pose (3,) of the base.

        last_inputs: speed (m/s) and turning rate (rad/s) at present; the plan is continued with them.
        running_cost: of poses (n, 3), after every step of the horizon; final_cost: of those at its end, (samples, 3).
        """
        self.plan = np.concatenate([self.plan[1:], np.asarray(last_inputs, float)[np.newaxis]])
        self.plan = self.improved(self.plan, self._noise(self.samples, self.horizon), pose, running_cost, final_cost)
        return np.array(self.plan[0])

    def improved(
        self,
        plan: Floats,
        noise: Floats,
        pose: ArrayLike,
        running_cost: Callable[[Floats], Floats],
        final_cost: Callable[[Floats], Floats],
    ) -> Floats:
        """The plan (horizon, 2) after one update with noise (samples, horizon, 2) on its inputs."""
        inputs = np.clip(plan + noise, self.lower, self.upper)
        noise = inputs - plan
        poses = np.broadcast_to(np.asarray(pose, float), (len(inputs), 3))
        cost = self.temperature * np.sum(plan * noise / np.asarray(self.variance), axis=(1, 2))
        way = []
        for step in range(inputs.shape[1]):
            poses = unicycle(poses, inputs[:, step], self.period)
            way.append(poses)
        # all at once: most of the time is in calls, not in numbers
        for step_cost in running_cost(np.concatenate(way)).reshape(len(way), -1):
            cost = cost + step_cost
        cost = cost + final_cost(poses)
        weight = np.exp(-(cost - cost.min()) / self.temperature)
        weight /= weight.sum()
        return np.asarray(plan + np.einsum("s,shi->hi", weight, noise))

    def _noise(self, *shape: int) -> Floats:
        return np.asarray(self.generator.standard_normal((*shape, 2)) * np.sqrt(self.variance))
