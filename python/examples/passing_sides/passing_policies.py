"""Two policies of the passing-side paper, for a differential base on the physical plant: vanilla MPC and IC-MPC.

Both drive the base by sampling MPC toward the goal and clear of one obstacle. IC-MPC also pays for the human's
uncertainty about the side on which the team passes the obstacle (arXiv:2502.03346).

Departures from their robot, a Stretch whose arm reaches out sideways with a wrist that the human can turn:

- Here the robot stands behind the object, so the cost at the end of the horizon is the object's distance from the
  goal, not the base's.
- The arm keeps its shape, and its first joint turns it toward the hand, as their wrist lets the object turn.
- The policy decides once per planning step, by default 5 times a second, not 15 times.
"""

from __future__ import annotations

import math
import pickle
from dataclasses import dataclass

import cocarry
import numpy as np

from passing_inference import LEFT, RIGHT, Floats, bearing_around, side_posterior
from sampling_mpc import Mppi, carried_position, goal_cost, uncertainty_cost
from scenes import Scene


@dataclass(frozen=True)
class Base:
    """A differential base with an arm whose first joint turns about an upright axis ahead of the wheels' axle."""

    #: Distance between the wheels, m.
    track_m: float = 0.374
    #: How far the axis of the arm's first joint is ahead of the axle, m.
    shoulder_ahead_m: float = 0.033
    #: Number of joints of the arm, and the largest rate of the first one, rad/s.
    joints: int = 7
    shoulder_rate_limit: float = 1.256

    def inputs(self, speed: float, rate: float, shoulder_rate: float) -> Floats:
        """u: rim speeds (m/s) of the left and the right wheel, then joint rates (rad/s)."""
        half = 0.5 * rate * self.track_m
        u = np.zeros(2 + self.joints)
        u[:3] = speed - half, speed + half, shoulder_rate
        return u


#: The built-in robot `carrier`.
CARRIER = Base()


@dataclass(frozen=True)
class _Sight:
    """What the policy saw at the beginning of a planning step."""

    time_s: float
    #: x, y (m) and yaw (rad) of the base, and the hand's position, m, in the world.
    base: Floats
    hand: Floats

    def velocities(self, last: _Sight | None) -> tuple[Floats, Floats]:
        """The base's speed ahead (m/s) and turning rate (rad/s), and the hand's velocity (2,), m/s, since `last`."""
        if last is None or self.time_s <= last.time_s:
            return np.zeros(2), np.zeros(2)
        period = self.time_s - last.time_s
        moved, turned = self.base[:2] - last.base[:2], _wrapped(self.base[2] - last.base[2])
        heading = last.base[2] + 0.5 * turned
        speed = float(moved @ (math.cos(heading), math.sin(heading)))
        return np.array([speed, turned]) / period, (self.hand - last.hand) / period


class VanillaMpc(cocarry.Policy):
    """Sampling MPC toward the goal and clear of one obstacle, which does not reason about the human.

    scene: the obstacle and the goal: `OnePost` for the paper's, `Walls` for other worlds.
    seed: of the samples.

    While the human follows, the robot leads on the option on whose side the object is; once the human takes the lead,
    it keeps it. The base is driven by the MPC either way. On plants without bodies, the human leads.
    """

    version = "1.0"
    name = "vanilla-mpc"
    #: The robot stands still once the object's centre is this near to the goal, m.
    STOP_DISTANCE_M = 0.25
    #: Time in which the arm's first joint turns toward the hand, s.
    TURNING_TIME_S = 0.4

    def __init__(self, scene: Scene, seed: int = 0, base: Base = CARRIER) -> None:
        self.scene, self.base = scene, base
        self.mppi = Mppi(seed)
        self.last: _Sight | None = None
        #: Posterior of left and right, as of the last planning step.
        self.posterior = np.full(2, 0.5)

    def decide(self, view: cocarry.RobotView) -> cocarry.Decision | None:
        """Who leads, and the inputs of base and arm for this planning step."""
        if view.configuration is None or view.hand is None or view.object is None:
            return None
        seen = _Sight(view.time_s, view.configuration[:3], view.hand[:2, 3])
        inputs, human_velocity = seen.velocities(self.last)
        self.last = seen
        position = np.asarray(view.object[:2, 3])
        obstacle, goal = self.scene.look(view, position)
        facing = np.array([math.cos(seen.base[2]), math.sin(seen.base[2])])
        self.posterior = side_posterior(obstacle, goal, position, human_velocity, inputs[0] * facing)
        if self.scene.is_near_end(position, self.STOP_DISTANCE_M):
            speed, rate = 0.0, 0.0
        else:
            held = _in_frame(seen.base, position)
            speed, rate = self.mppi.command(
                seen.base,
                inputs,
                lambda poses: self._running_cost(poses, held, obstacle, goal, human_velocity),
                lambda poses: goal_cost(carried_position(poses, held), goal),
            )
        u = self.base.inputs(speed, rate, self._shoulder_rate(view, seen, rate))
        return cocarry.Decision(lead=self._lead(view, obstacle, goal), inputs=u)

    def _running_cost(self, poses: Floats, held: Floats, obstacle: Floats, goal: Floats, human_velocity: Floats) -> Floats:
        """The cost of poses (n, 3) of a base that holds the object at (2,), m, in its own frame."""
        return self.scene.clearance(poses[:, :2])

    def _shoulder_rate(self, view: cocarry.RobotView, seen: _Sight, turning_rate: float) -> float:
        """Rate of the arm's first joint, rad/s, that turns arm and object toward the hand while the base turns."""
        assert view.grasp is not None
        heading = np.array([math.cos(seen.base[2]), math.sin(seen.base[2])])
        shoulder = seen.base[:2] + self.base.shoulder_ahead_m * heading
        to_grasp, to_hand = view.grasp[:2, 3] - shoulder, seen.hand - shoulder
        error = _wrapped(math.atan2(to_hand[1], to_hand[0]) - math.atan2(to_grasp[1], to_grasp[0]))
        limit = self.base.shoulder_rate_limit
        return min(max(error / self.TURNING_TIME_S - turning_rate, -limit), limit)

    def _lead(self, view: cocarry.RobotView, obstacle: Floats, goal: Floats) -> int | None:
        """The option on which the robot leads; None once the human has taken the lead."""
        if view.stance == "take-over" or (view.mode == "human-led" and view.executed is not None):
            return None
        return self.scene.option(view, self._side(view, obstacle, goal))

    def _side(self, view: cocarry.RobotView, obstacle: Floats, goal: Floats) -> int:
        """The side that the robot takes the team to pass on: here, the one where it is."""
        return LEFT if bearing_around(obstacle, goal, view.position) >= 0.0 else RIGHT

    def save(self) -> bytes:
        """The plan, the generator, and what was seen last."""
        return pickle.dumps((self.mppi.plan, self.mppi.generator.bit_generator.state, self.last, self.posterior))

    def restore(self, state: bytes) -> None:
        """Restores what `save` returned."""
        self.mppi.plan, self.mppi.generator.bit_generator.state, self.last, self.posterior = pickle.loads(state)


class IcMpc(VanillaMpc):
    """IC-MPC: the same, and the robot moves such that the human can tell the side on which the team passes.

    uncertainty_weight: weight of the entropy of the side, per bit, against the other costs (code: 1).
    """

    name = "ic-mpc"

    def __init__(self, scene: Scene, seed: int = 0, base: Base = CARRIER, uncertainty_weight: float = 1.0) -> None:
        super().__init__(scene, seed, base)
        self.uncertainty_weight = uncertainty_weight

    def _running_cost(self, poses: Floats, held: Floats, obstacle: Floats, goal: Floats, human_velocity: Floats) -> Floats:
        """That of vanilla MPC, and the human's uncertainty."""
        uncertainty = uncertainty_cost(poses, held, obstacle, goal, human_velocity)
        return self.scene.clearance(poses[:, :2]) + self.uncertainty_weight * uncertainty

    def _side(self, view: cocarry.RobotView, obstacle: Floats, goal: Floats) -> int:
        """The likelier side of the posterior."""
        return int(np.argmax(self.posterior))


def _in_frame(base: Floats, position: Floats) -> Floats:
    """A position, m, in the frame of a base at x, y (m) and yaw (rad): ahead and to the left."""
    offset, cosine, sine = position - base[:2], math.cos(base[2]), math.sin(base[2])
    return np.array([cosine * offset[0] + sine * offset[1], cosine * offset[1] - sine * offset[0]])


def _wrapped(angle: float) -> float:
    """The angle from -pi to pi, rad."""
    return math.remainder(angle, 2.0 * math.pi)
