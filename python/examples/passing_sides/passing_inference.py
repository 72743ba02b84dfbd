"""Bayesian inference over the side on which a team passes an obstacle: prior by geometry, likelihood of velocities.

After E. Yang and C. Mavrogiannis, "Implicit Communication in Human-Robot Collaborative Transport", HRI 2025
(arXiv:2502.03346). Where the text leaves a number open, it is that of the authors' public code
(fluentrobotics/icmpc_collab_transport, BSD-3-Clause), and the constant says so. This is an implementation of its own.

Positions are in metres and velocities in metres per second, in one frame on the floor, x to y counter-clockwise.
Functions take one state or many: arrays of shape (..., 2) give results of shape (...).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

#: The index of each side in the last axis of every distribution: the obstacle is to the right of a team that passes it
#: on the left.
LEFT, RIGHT = 0, 1
#: Number of directions of a velocity; the action with this index is to stand still (code).
DIRECTIONS = 8
#: A velocity below this is standing still, m/s (code).
STANDING_SPEED_M_PER_S = 0.1
#: The angle by which the direction of a side departs from that to the obstacle, rad (code).
SIDE_ANGLE_RAD = math.pi / 3


def bearing_around(obstacle: ArrayLike, goal: ArrayLike, position: ArrayLike) -> Floats:
    """Signed angle theta at the obstacle from the goal to a position, rad, from -pi to pi.

    It is 0 where the team has passed the obstacle in line with the goal, pi or -pi before it, and positive where the
    team is on the left as seen in the direction of the goal.
    """
    to_goal = np.asarray(goal, float) - obstacle
    to_position = np.asarray(position, float) - obstacle
    cross = to_goal[..., 0] * to_position[..., 1] - to_goal[..., 1] * to_position[..., 0]
    dot = np.sum(to_goal * to_position, axis=-1)
    return np.asarray(np.arctan2(cross, dot))


def has_passed(obstacle: ArrayLike, goal: ArrayLike, position: ArrayLike) -> NDArray[np.bool_]:
    """Whether a position is beyond the obstacle: |theta| < pi/2."""
    return np.abs(bearing_around(obstacle, goal, position)) < math.pi / 2


def side_prior(obstacle: ArrayLike, goal: ArrayLike, position: ArrayLike) -> Floats:
    """Prior probability of each side from where the object is, (..., 2).

    The side on which the object is has min(1, 1/2 + (pi - |theta|) / pi): one half straight before the obstacle, one
    beside and beyond it.
    """
    theta = bearing_around(obstacle, goal, position)
    nearer = np.minimum(0.5 + (math.pi - np.abs(theta)) / math.pi, 1.0)
    left = np.where(theta >= 0.0, nearer, 1.0 - nearer)
    right = np.where(theta >= 0.0, 1.0 - nearer, nearer)
    return np.stack([left, right], axis=-1)


def action_likelihood(obstacle: ArrayLike, goal: ArrayLike, position: ArrayLike) -> Floats:
    """Probability of every action of one partner, given the side: (..., 2, DIRECTIONS + 1).

    Action i is the direction 2 pi i / DIRECTIONS, the last one is standing still. Before the obstacle, the score of a
    direction d is (d . n) (1 + d . g) / 2, with the direction n of the side (that to the obstacle, turned outward by
    SIDE_ANGLE_RAD) and the direction g to the goal. Beyond it, the score is d . g for both sides. Standing still has
    the score 0. The softmax of the scores is the probability.

    The result is NaN where the position is the goal or the obstacle.
    """
    position = np.asarray(position, float)
    to_goal = _unit(np.asarray(goal, float) - position)
    to_obstacle = _unit(np.asarray(obstacle, float) - position)
    angles = np.arange(DIRECTIONS) * (2.0 * math.pi / DIRECTIONS)
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    goalward = to_goal @ directions.T
    sides = np.stack([_turned(to_obstacle, angle) @ directions.T for angle in (SIDE_ANGLE_RAD, -SIDE_ANGLE_RAD)], axis=-2)
    before = sides * ((1.0 + goalward) / 2.0)[..., np.newaxis, :]
    beyond = np.broadcast_to(goalward[..., np.newaxis, :], before.shape)
    passed = has_passed(obstacle, goal, position)
    score = np.where(passed[..., np.newaxis, np.newaxis], beyond, before)
    score = np.concatenate([score, np.zeros((*score.shape[:-1], 1))], axis=-1)
    weight = np.exp(score)
    return np.asarray(weight / weight.sum(axis=-1, keepdims=True))


def action_of(velocity: ArrayLike) -> NDArray[np.intp]:
    """The action of a velocity (..., 2), m/s: the nearest direction, or DIRECTIONS for standing still."""
    velocity = np.asarray(velocity, float)
    angle = np.arctan2(velocity[..., 1], velocity[..., 0]) % (2.0 * math.pi)
    nearest = np.rint(angle / (2.0 * math.pi) * DIRECTIONS).astype(np.intp) % DIRECTIONS
    stands = np.hypot(velocity[..., 0], velocity[..., 1]) < STANDING_SPEED_M_PER_S
    return np.where(stands, DIRECTIONS, nearest)


def side_posterior(
    obstacle: ArrayLike, goal: ArrayLike, position: ArrayLike, human_velocity: ArrayLike, robot_velocity: ArrayLike
) -> Floats:
    """Posterior probability of each side, (..., 2), given the object's position and both partners' velocities.

    Proportional to prior times likelihood of the human's action times likelihood of the robot's action: given the
    side, the two act independently.
    """
    likelihood = action_likelihood(obstacle, goal, position)

    def of(velocity: ArrayLike) -> Floats:
        action = np.broadcast_to(action_of(velocity), likelihood.shape[:-2])
        return np.take_along_axis(likelihood, action[..., np.newaxis, np.newaxis], axis=-1)[..., 0]

    joint = side_prior(obstacle, goal, position) * of(human_velocity) * of(robot_velocity)
    return np.asarray(joint / joint.sum(axis=-1, keepdims=True))


def entropy(distribution: ArrayLike) -> Floats:
    """Entropy of a distribution (..., n), bit; a probability of 0 adds nothing."""
    probability = np.asarray(distribution, float)
    logarithm = np.log2(np.where(probability > 0.0, probability, 1.0))
    return np.asarray(-np.sum(probability * logarithm, axis=-1))


def _unit(vector: Floats) -> Floats:
    """The vectors (..., 2) at length 1."""
    return np.asarray(vector / np.hypot(vector[..., 0], vector[..., 1])[..., np.newaxis])


def _turned(vector: Floats, angle: float) -> Floats:
    """The vectors (..., 2) turned counter-clockwise by an angle, rad."""
    cosine, sine = math.cos(angle), math.sin(angle)
    x, y = vector[..., 0], vector[..., 1]
    return np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=-1)
