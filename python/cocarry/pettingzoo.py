"""PettingZoo: robot and human are both agents, ``cocarry.pettingzoo.parallel_env()``.

The planning level. In every planning step both agents act at once. The robot chooses the option to lead on, or follows;
the human chooses the option preferred, and whether to follow, to resist (the team stands still) or to take over. The
robot's reward is minus ``objective_weight`` J, the human's minus ``subjective_weight`` J^ with the human's alpha and
gamma (eq. 1 and 2). Stubbornness phi grows by eq. (5); it is shown, and forces nobody.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from pettingzoo import ParallelEnv
from pettingzoo.utils.conversions import parallel_to_aec

from cocarry import _arguments, _cocarry
from cocarry._cocarry import World
from cocarry.environments import _ENVIRONMENTS, _MODES, _WISHES, _check_render_mode, _Resumable, _seed, _space, _wish

__all__ = ["CocarryEnv", "env", "parallel_env"]


class CocarryEnv(_Resumable, ParallelEnv):  # type: ignore[misc]
    """The environment of two agents, ``robot`` and ``human``.

    Actions: robot, Discrete(n + 1): i leads on option i, n follows. human, MultiDiscrete([n, 3]): the option preferred,
    then 0 to follow, 1 to resist, 2 to take over. Observations: Box, float64: as of cocarry/Options-v0; the human's has
    alpha and gamma at its end, and is the ``state()`` of the environment too. ``infos[agent]["action_mask"]`` is for
    ``action_space(agent).sample(mask)``: 0 for options that the episode's world does not have. max_cycles: steps after
    which the episode is truncated. Other keywords as of cocarry/Options-v0. Environments can be copied
    (``copy.deepcopy``) and pickled in mid-episode.
    """

    metadata: dict[str, Any] = {"name": "cocarry_v0", "render_modes": list(_MODES), "is_parallelizable": True}  # noqa: RUF012

    def __init__(
        self,
        worlds: str | World | Sequence[str | World] = _ENVIRONMENTS,
        *,
        alpha: float | None = None,
        gamma: float | None = None,
        objective_weight: float = 1.0,
        subjective_weight: float = 1.0,
        max_cycles: int | None = None,
        render_mode: str | None = None,
        **settings: Any,
    ) -> None:
        _check_render_mode(render_mode)
        weights = (objective_weight, subjective_weight, 0.0)
        if max_cycles is not None:
            _arguments.whole("max_cycles", max_cycles, 1)
        self._make(1, "both", worlds, "point", settings, alpha=alpha, gamma=gamma, max_steps=max_cycles, weights=weights)
        self._weights, self.render_mode = weights[:2], render_mode
        self.possible_agents = ["robot", "human"]
        self.agents: list[str] = []
        shown, n = _space(self._lanes), self._lanes.options
        human = spaces.Box(np.append(shown.low, [0.0, 0.0]), np.append(shown.high, [10.0, 10.0]), dtype=np.float64)
        self.observation_spaces = {"robot": shown, "human": human}
        self.state_space = human
        self.action_spaces = {"robot": spaces.Discrete(n + 1), "human": spaces.MultiDiscrete([n, 3])}
        self._actions: list[list[float]] = []
        self._is_seeded = False

    def observation_space(self, agent: str) -> Any:
        """The space of an agent's observations."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> Any:
        """The space of an agent's actions."""
        return self.action_spaces[agent]

    def _observations(self) -> dict[str, Any]:
        shown, episode = self._lanes.observations[0].copy(), self._lanes.episode(0)
        return {"robot": shown, "human": np.append(shown, [episode["alpha"], episode["gamma"]])}

    def state(self) -> Any:
        """Everything that is known of the present: the robot's observation, then the human's alpha and gamma."""
        return self._observations()["human"]

    def _masks(self) -> dict[str, Any]:
        """The actions that each agent has in the episode's world."""
        mask = self._lanes.action_masks[0]
        return {"robot": {"action_mask": mask}, "human": {"action_mask": (mask[:-1].copy(), np.ones(3, dtype=np.int8))}}

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[dict[str, Any], dict[str, Any]]:
        """Begins an episode. ``options`` may set ``world`` (an index or a name), ``seed``, ``alpha`` and ``gamma`` of it; others
        are ignored, as PettingZoo's tests ask."""
        given = {} if options is None else _arguments.mapping("options", options)
        wish = _wish({key: value for key, value in given.items() if key in _WISHES})
        if seed is not None or not self._is_seeded:
            self._lanes.seed(0, int(np.random.default_rng().integers(2**62)) if seed is None else _seed(seed))
        self._is_seeded = True
        self._lanes.reset(**wish)
        self.agents = list(self.possible_agents)
        self._actions.clear()
        masks = self._masks()
        return self._observations(), {agent: self._lanes.episode(0) | masks[agent] for agent in self.agents}

    def step(self, actions: dict[str, Any]) -> tuple[dict[str, Any], dict[str, float], dict[str, bool], dict[str, bool], dict[str, Any]]:
        """One planning step (0.2 s by default)."""
        if not self.agents:
            raise _cocarry.ClosedError("the environment has no episode; call reset() first")
        _arguments.mapping("actions", actions, _cocarry.ActionError)
        missing = [agent for agent in self.agents if agent not in actions]
        if missing:
            raise _cocarry.ActionError(f"there is no action of {missing[0]!r}; expected one of every agent: {', '.join(self.agents)}")
        parts = [np.asarray(actions["robot"]), np.asarray(actions["human"])]
        if parts[0].shape != () or parts[1].shape != (2,) or any(part.dtype.kind not in "iu" for part in parts):
            raise _cocarry.ActionError(
                f"actions {actions!r}; the robot's must be a whole number, the human's two: an option and a response from 0 to 2"
            )
        row = np.array([[int(parts[0]), *map(int, parts[1])]], dtype=np.int64)
        self._lanes.step(row)
        self._actions.append(row[0].astype(np.float64).tolist())
        objective, subjective, _ = self._lanes.costs(0)
        agents = list(self.agents)
        rewards = {"robot": -self._weights[0] * objective, "human": -self._weights[1] * subjective}
        terminated, truncated = bool(self._lanes.terminated[0]), bool(self._lanes.truncated[0])
        info: dict[str, Any] = {}
        if terminated or truncated:
            summary = self._lanes.summary(0)
            assert summary is not None
            info = {"outcome": summary["outcome"], "summary": summary}
            self.agents = []
        return (
            self._observations(),
            rewards,
            dict.fromkeys(agents, terminated),
            dict.fromkeys(agents, truncated),
            {agent: info | mask for agent, mask in self._masks().items()},
        )

    def render(self) -> Any:
        """The world from above with the way walked, (height, width, 3) uint8, or the page of the 3-D player."""
        if self.render_mode is None:
            return None
        return self._picture(0, self._actions)

    def close(self) -> None:
        """Ends the environment."""
        self.agents = []


def parallel_env(*args: Any, **keywords: Any) -> CocarryEnv:
    """The environment in which both agents act at once."""
    return CocarryEnv(*args, **keywords)


def env(*args: Any, **keywords: Any) -> Any:
    """The environment in which the agents act in turn (AEC)."""
    return parallel_to_aec(CocarryEnv(*args, **keywords))
