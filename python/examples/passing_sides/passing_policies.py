"""Two policies of the passing-side paper on the physical plant: vanilla MPC and IC-MPC.

Both move the robot's end of the object by sampling MPC toward the goal and clear of one obstacle. IC-MPC also pays for
the human's uncertainty about the side on which the team passes the obstacle (arXiv:2502.03346).

Departures from their robot, a Stretch whose arm reaches out sideways with a wrist that the human can turn:

- What their MPC plans for the base, it plans here for the robot's end of the object: a point with a heading, which eq. (7)
  then follows with base and arm. Here the robot stands behind the object, so a base that swings out pulls the object
  along, and meets the walls.
- The cost at the end of the horizon is the object's distance from the goal, not the base's.
- The object's heading is that to the hand, as their wrist lets the object turn.
- The policy decides once per planning step, by default 5 times a second, not 15 times.
"""

from __future__ import annotations

import math
import pickle
from dataclasses import dataclass

import cocarry
import numpy as np

from passing_inference import LEFT, RIGHT, Floats, bearing_around, side_posterior
from sampling_mpc import Mppi, carried_position, goal_cost, uncertainty_cost, unicycle
from scenes import Scene, Walls

#: Number of poses of a reference.
REFERENCES = 8


@dataclass(frozen=True)
class _Sight:
    """What the policy saw at the beginning of a planning step: time (s), and the positions of grasp and hand, m."""

    time_s: float
    grasp: Floats
    hand: Floats


class VanillaMpc(cocarry.Policy):
    """Sampling MPC toward the goal and clear of one obstacle, which does not reason about the human.

    scene: the obstacle and the goal: `OnePost` for the paper's; by default `Walls` of the world that the first view has.
    seed: of the samples.

    While the human follows, the robot leads on the option on whose side the object is; once the human takes the lead,
    they keep it. The MPC moves the robot either way. On plants without bodies, the human leads.
    Without a scene, the team starts facing the way of the robot's option; with one, that of the human's.
    """

    version = "1.0"
    name = "vanilla-mpc"
    #: The robot stands still once the object's centre is this near to the goal, m.
    STOP_DISTANCE_M = 0.25

    def __init__(self, scene: Scene | None = None, seed: int = 0) -> None:
        self.given_scene = scene
        self.mppi = Mppi(seed)
        self.last: _Sight | None = None
        #: The heading (rad) in which the robot's end of the object moves, and its turning rate (rad/s).
        self.heading, self.rate = math.nan, 0.0
        #: Posterior of left and right, as of the last planning step.
        self.posterior = np.full(2, 0.5)

    def decide(self, view: cocarry.RobotView) -> cocarry.Decision | None:
        """Who leads, and the reference of the grasp for the next planning steps."""
        if view.grasp is None or view.hand is None or view.object is None:
            # the first step is tried without the robot's grasp: the team starts facing the way of the option led on there
            is_trial = view.robot is not None and view.grasp is None
            return cocarry.Decision(Walls(view.world).option(view, LEFT)) if is_trial and self.given_scene is None else None
        if self.given_scene is None:
            self.given_scene = Walls(view.world)
        seen = _Sight(view.time_s, np.asarray(view.grasp[:2, 3]), np.asarray(view.hand[:2, 3]))
        velocity, human_velocity = self._velocities(seen)
        if math.isnan(self.heading):
            self.heading = math.atan2(view.object[1, 0], view.object[0, 0])
        facing = np.array([math.cos(self.heading), math.sin(self.heading)])
        position = np.asarray(view.object[:2, 3])
        obstacle, goal = self.scene.look(view, position)
        self.posterior = side_posterior(obstacle, goal, position, human_velocity, velocity)
        pose = np.array([*seen.grasp, self.heading])
        if self.scene.is_near_end(position, self.STOP_DISTANCE_M):
            plan = np.zeros((self.mppi.horizon, 2))
        else:
            held = _in_frame(pose, position)
            inputs = max(0.0, float(velocity @ facing)), self.rate
            self._improve(pose, inputs, held, obstacle, goal, human_velocity)
            plan = self.mppi.plan
        way = planned_poses(pose, plan, self.mppi.period, view.planning_step_s)
        self.last, self.heading, self.rate = seen, float(way[0, 2]), float(plan[0, 1])
        reference = facing_hand(way, seen.hand, human_velocity, view.planning_step_s)
        return cocarry.Decision(lead=self._lead(view, obstacle, goal), reference=reference)

    @property
    def scene(self) -> Scene:
        """The scene given, or that of the first view's world."""
        if self.given_scene is None:
            raise ValueError("scene: not known before the first decision; give one, or ask afterwards")
        return self.given_scene

    def _velocities(self, seen: _Sight) -> tuple[Floats, Floats]:
        """The velocities (2,) of grasp and hand since the last planning step, m/s."""
        if self.last is None or seen.time_s <= self.last.time_s:
            return np.zeros(2), np.zeros(2)
        period = seen.time_s - self.last.time_s
        return (seen.grasp - self.last.grasp) / period, (seen.hand - self.last.hand) / period

    def _improve(
        self, pose: Floats, inputs: tuple[float, float], held: Floats, obstacle: Floats, goal: Floats, human_velocity: Floats
    ) -> None:
        """Improves the plan, from a pose (3,) of the robot's end and its inputs at present; `held` as in `_running_cost`."""
        self.mppi.command(
            pose,
            inputs,
            lambda poses: self._running_cost(poses, held, obstacle, goal, human_velocity),
            lambda poses: goal_cost(carried_position(poses, held), goal),
        )

    def _running_cost(self, poses: Floats, held: Floats, obstacle: Floats, goal: Floats, human_velocity: Floats) -> Floats:
        """The cost of poses (n, 3) of the robot's end, with the object's centre at `held` (2,), m, in their frame."""
        return self.scene.clearance(poses[:, :2], carried_position(poses, held))

    def _lead(self, view: cocarry.RobotView, obstacle: Floats, goal: Floats) -> int | None:
        """The option on which the robot leads; None once the human has taken the lead."""
        if view.stance == "take-over" or (view.mode == "human-led" and view.executed is not None):
            return None
        return self.scene.option(view, self._side(view, obstacle, goal))

    def _side(self, view: cocarry.RobotView, obstacle: Floats, goal: Floats) -> int:
        """The side that the robot takes the team to pass on: here, the one where it is."""
        return LEFT if bearing_around(obstacle, goal, view.position) >= 0.0 else RIGHT

    def save(self) -> bytes:
        """The plan, the generator, and what was seen and done last. A scene comes from the views again."""
        state = self.mppi.plan, self.mppi.generator.bit_generator.state
        return pickle.dumps((*state, self.last, self.heading, self.rate, self.posterior))

    def restore(self, state: bytes) -> None:
        """Restores what `save` returned."""
        self.mppi.plan, generator, self.last, self.heading, self.rate, self.posterior = pickle.loads(state)
        self.mppi.generator.bit_generator.state = generator


class IcMpc(VanillaMpc):
    """IC-MPC: the same, and the robot moves such that the human can tell the side on which the team passes.

    uncertainty_weight: weight of the entropy of the side, per bit, against the other costs (code: 1).
    """

    name = "ic-mpc"

    def __init__(self, scene: Scene | None = None, seed: int = 0, uncertainty_weight: float = 1.0) -> None:
        super().__init__(scene, seed)
        self.uncertainty_weight = uncertainty_weight

    def _running_cost(self, poses: Floats, held: Floats, obstacle: Floats, goal: Floats, human_velocity: Floats) -> Floats:
        """That of vanilla MPC, and the human's uncertainty."""
        uncertainty = uncertainty_cost(poses, held, obstacle, goal, human_velocity)
        return self.scene.clearance(poses[:, :2], carried_position(poses, held)) + self.uncertainty_weight * uncertainty

    def _side(self, view: cocarry.RobotView, obstacle: Floats, goal: Floats) -> int:
        """The likelier side of the posterior."""
        return int(np.argmax(self.posterior))


def planned_poses(pose: Floats, plan: Floats, period: float, planning_step: float) -> Floats:
    """The poses (REFERENCES, 3) at the ends of the next planning steps (s), of inputs (n, 2) for a period (s) each."""
    step = planning_step / 4.0
    poses = []
    for i in range(4 * REFERENCES):
        pose = unicycle(pose, plan[min(int((i + 0.5) * step / period), len(plan) - 1)], step)
        poses.append(pose)
    return np.array(poses[3::4])


def facing_hand(way: Floats, hand: Floats, hand_velocity: Floats, planning_step: float) -> Floats:
    """The positions of poses (n, 3), a planning step (s) apart, with the heading to a hand that keeps its velocity (m/s)."""
    times = planning_step * np.arange(1, len(way) + 1)
    to_hand = hand + times[:, np.newaxis] * hand_velocity - way[:, :2]
    return np.column_stack([way[:, :2], np.arctan2(to_hand[:, 1], to_hand[:, 0])])


def _in_frame(pose: Floats, position: Floats) -> Floats:
    """A position, m, in the frame of a pose x, y (m) and yaw (rad): ahead and to the left."""
    offset, cosine, sine = position - pose[:2], math.cos(pose[2]), math.sin(pose[2])
    return np.array([cosine * offset[0] + sine * offset[1], cosine * offset[1] - sine * offset[0]])
