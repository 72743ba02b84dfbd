"""Custom policies and humans: base classes to subclass, and their decisions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from cocarry._cocarry import HandView, HumanView, RobotView


@dataclass(frozen=True)
class Decision:
    """A decision of the robot's policy in a planning step.

    lead: the option on which the robot leads, an index or a name; None or ``"human"``: the human leads, on the
        option preferred now; ``"human-keeping-option"``: on the option chosen at the start.
    reference: (8, 3), poses of the grasp in the world, x, y (m) and yaw (rad), one for the end of each of the
        next 8 planning steps; eq. (7) follows them. The kinematic and the physical plant only.
    inputs: (base + joints,), the inputs u: rim speed of the left and the right wheel (m/s), or of an omnidirectional
        base velocity ahead and to the left (m/s) and turning rate (rad/s); then joint rates (rad/s,
        prismatic m/s). The kinematic and the physical plant only.

    Without a reference or inputs, the robot's controller moves it (eq. 8 and 7).
    """

    lead: int | str | None = None
    reference: NDArray[np.float64] | None = None
    inputs: NDArray[np.float64] | None = None


@dataclass(frozen=True)
class HumanDecision:
    """A decision of the human in a planning step.

    option: the option that the human prefers, an index or a name.
    stance: the response to the robot's lead. By default the human takes over once stubbornness exceeds 1.
    stubbornness: phi(k), at least 0; by default that of eq. (5).
    discomfort: g(k), at least 0; by default that of eq. (5).
    perception: alpha and gamma behind the decision, for the figures of the subjective cost.
    hand: target of the hand (x, y) at the end of the planning step, m, in the world, on the physical plant; the hand
        goes straight to it. ``Human.hand`` gives a target for every control period.
    """

    option: int | str
    stance: Literal["follow", "resist", "take-over"] | None = None
    stubbornness: float | None = None
    discomfort: float | None = None
    perception: tuple[float, float] | None = None
    hand: tuple[float, float] | None = None


class Policy:
    """A custom policy of the robot. Subclass it and write ``decide``; a plain function does as well.

    An episode with a robot tries its first step on a deep copy, without the robot, to know which way the team faces
    at the start; if ``decide`` fails there, the team faces the option that the human prefers. A policy with memory that snapshots should keep writes ``save``
    and ``restore``.
    """

    #: Whether the human leads before the first step.
    human_leads_first: bool = False
    #: Whether P_o and J~_o are also needed while the human leads.
    predicts: bool = False

    def decide(self, view: RobotView) -> Decision | int | str | None:
        """The decision at the beginning of a planning step: an option to lead on, None to follow, or a Decision."""
        raise NotImplementedError

    def save(self) -> bytes:
        """The state that later decisions depend on."""
        return b""

    def restore(self, state: bytes) -> None:
        """Restores what ``save`` returned. Not called for an empty state."""


class Human:
    """A custom human. Subclass it and write ``decide``; a plain function does as well.

    A human who returns only an option has the stubbornness of eq. (5), and takes the lead once it exceeds 1.
    """

    def decide(self, view: HumanView) -> HumanDecision | int | str:
        """The decision at the beginning of a planning step: the option preferred, or a HumanDecision."""
        raise NotImplementedError

    def hand(self, view: HandView) -> tuple[float, float] | None:
        """Target of the hand (x, y) at the end of a control period, m, in the world, on the physical plant; None:
        straight to the target of the decision, or, if that has none, with the leader."""
        return None

    def save(self) -> bytes:
        """The state that later decisions depend on."""
        return b""

    def restore(self, state: bytes) -> None:
        """Restores what ``save`` returned. Not called for an empty state."""
