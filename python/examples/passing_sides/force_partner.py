"""A human who pulls toward their own option, gives way to force, and may change their mind.

The hand is an admittance: it moves at the human's preferred velocity plus the force on it over the damping. So a robot
and a human who want different sides meet as forces on the object, as people do. Who follows a path is the hand, so the
human does so whoever leads.
"""

from __future__ import annotations

import math
import pickle
from collections.abc import Sequence

import cocarry
import numpy as np

from passing_inference import Floats
from scenes import Walls


class ForcePartner(cocarry.Human):
    """A human who walks their own option by force.

    option: the index of the option that the human prefers at the start.
    paths: the path of every option, (n, 2), m; by default those of the first view.
    reach_m: how far the hand is ahead of the object's centre, half its length.
    speed_m_per_s: the preferred speed.
    damping: force per speed by which the hand gives way, N s/m.
    patience_ns: how much force (N, times seconds) against their own option the human bears before taking the option
        toward which the force pulls; infinite for one who never does.
    walls: if given, the human steps aside from faces nearer than CLEAR_M to their body's axis.
    """

    version = "1.0"
    name = "force"
    #: How far ahead on their path the human looks, m.
    LOOKAHEAD_M = 0.5
    #: How far the human's body is ahead of the hand, m.
    BODY_AHEAD_M = 0.4
    #: The human slows down at this distance from the end, m.
    SLOWING_M = 0.3
    #: The human's body keeps this far from walls, m: its radius is 0.2 m.
    CLEAR_M = 0.5
    #: Forces below this do not count against the human's option, N.
    NOTICED_FORCE_N = 5.0
    #: Largest speed of the hand as a multiple of the preferred one.
    FASTEST = 1.6

    def __init__(
        self,
        option: int,
        *,
        paths: Sequence[Floats] | None = None,
        reach_m: float = 0.45,
        speed_m_per_s: float = 0.3,
        damping: float = 150.0,
        patience_ns: float = 40.0,
        walls: Walls | None = None,
    ) -> None:
        self.option, self.patience_ns, self.walls, self.reach_m = option, patience_ns, walls, reach_m
        #: The paths, and how they go on for the hand; none before the first decision.
        self.paths = [] if paths is None else [self._for_hand(path) for path in paths]
        self.speed_m_per_s, self.damping = speed_m_per_s, damping
        self.wrench: Floats | None = None
        #: The direction in which the object is ahead at the hand, of length 1.
        self.facing = np.zeros(2)
        self.time_s = 0.0
        #: Force times time against the human's option so far, N s.
        self.opposed_ns = 0.0

    def decide(self, view: cocarry.HumanView) -> cocarry.HumanDecision:
        """The option that the human prefers now; phi grows by eq. (5)."""
        if not self.paths:
            found = [view.path(option) for option in range(len(view))]
            if any(path is None for path in found):
                raise ValueError(f"{view.world.name}: option {found.index(None)} has no path from the start; give paths")
            self.paths = [self._for_hand(path) for path in found if path is not None]
        if view.hand is not None and view.hand_wrench is not None:
            self.wrench = np.asarray(view.hand_wrench)
            self.facing = view.hand[:2, 0] / math.hypot(*view.hand[:2, 0])
            self._reconsider(view.hand[:2, 3], -self.wrench[:2], view.time_s - self.time_s)
        self.time_s = view.time_s
        return cocarry.HumanDecision(self.option)

    def hand(self, view: cocarry.HandView) -> tuple[float, float]:
        """The target of the hand at the end of the control period, m."""
        wrench = self.wrench if view.hand_wrench is None or view.period == 0 else view.hand_wrench
        pull = np.zeros(2) if wrench is None else -np.asarray(wrench)[:2]
        here = np.asarray(view.hand)
        velocity = self.speed_m_per_s * (self._ahead(self.option, here) + self._aside(here)) + pull / self.damping
        fastest = self.FASTEST * self.speed_m_per_s
        speed = math.hypot(*velocity)
        if speed > fastest:
            velocity *= fastest / speed
        target = here + velocity * view.control_period_s
        return float(target[0]), float(target[1])

    def _for_hand(self, path: Floats) -> Floats:
        """A path that goes on for as long as the human is ahead of the object's centre at its end."""
        return _extended(np.asarray(path, float), self.reach_m + self.BODY_AHEAD_M)

    def _reconsider(self, here: Floats, pull: Floats, passed_s: float) -> None:
        """Takes the option toward which the force pulls, once it has pulled enough."""
        own = self._ahead(self.option, here)
        across = pull - own * float(pull @ own)
        force = math.hypot(*across)
        others = [option for option in range(len(self.paths)) if option != self.option]
        if force < self.NOTICED_FORCE_N or not others:
            return
        toward = max(others, key=lambda option: float(across @ self._ahead(option, here)))
        if float(across @ self._ahead(toward, here)) <= 0.1 * force:
            return
        self.opposed_ns += force * passed_s
        if self.opposed_ns > self.patience_ns:
            self.option, self.opposed_ns = toward, 0.0

    def _ahead(self, option: int, here: Floats) -> Floats:
        """The direction in which the human walks on an option, of length 1, and less within SLOWING_M of its end."""
        path, body = self.paths[option], here + self.BODY_AHEAD_M * self.facing
        offsets = path - body
        nearest = int(np.argmin(np.hypot(offsets[:, 0], offsets[:, 1])))
        along = np.hypot(*np.diff(path[nearest:], axis=0).T).cumsum()
        beyond = nearest + 1 + int(np.searchsorted(along, self.LOOKAHEAD_M))
        to = path[min(beyond, len(path) - 1)] - body
        return np.asarray(to / max(math.hypot(*to), self.SLOWING_M))

    def _aside(self, here: Floats) -> Floats:
        """The direction away from the nearest face, the longer the nearer it is: 0 at CLEAR_M, 2 where the body touches."""
        if self.walls is None:
            return np.zeros(2)
        body = here + self.BODY_AHEAD_M * self.facing
        [nearest], [distance] = self.walls.nearest([body])
        if not 0.0 < distance < self.CLEAR_M:
            return np.zeros(2)
        return np.asarray((body - nearest) / distance * 2.0 * (self.CLEAR_M - distance) / (self.CLEAR_M - 0.2))

    def save(self) -> bytes:
        """Option, force borne, what was felt and seen last, and the paths."""
        return pickle.dumps((self.option, self.opposed_ns, self.wrench, self.time_s, self.facing, self.paths))

    def restore(self, state: bytes) -> None:
        """Restores what `save` returned."""
        self.option, self.opposed_ns, self.wrench, self.time_s, self.facing, self.paths = pickle.loads(state)


def _extended(path: Floats, reach: float) -> Floats:
    """A path with points every 5 cm, which goes on straight by a length, m."""
    last = path[-1] - path[-2]
    path = np.vstack([path, path[-1] + reach * last / math.hypot(*last)])
    along = np.concatenate([[0.0], np.hypot(*np.diff(path, axis=0).T).cumsum()])
    at = np.linspace(0.0, along[-1], max(2, math.ceil(along[-1] / 0.05)))
    return np.stack([np.interp(at, along, path[:, axis]) for axis in range(2)], axis=-1)
