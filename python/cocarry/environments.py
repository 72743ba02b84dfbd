"""Environments for learners: Gymnasium's ``cocarry/Options-v0`` and ``cocarry/Carry-v0``.

Importing this module registers them::

    import gymnasium
    import cocarry.environments

    environment = gymnasium.make("cocarry/Options-v0", worlds=["environment-4"])
    vector = gymnasium.make_vec("cocarry/Options-v0", num_envs=64)

An episode draws a world, a seed, and a human of that seed from the robot's belief. An environment's generator is
seeded by ``reset(seed=)`` and draws every later episode too. A change of any result raises the ids' version.

The reward of a step is minus ``objective_weight`` J minus ``subjective_weight`` J^ minus ``control_weight`` C: the
objective cost of the option executed (m, eq. 1), its subjective cost to this human (cost units, eq. 2), and the
control cost of the step (Sec. V-C). Summed over an episode, these are the paper's figures.

An episode is terminated when it arrives, fails (collided, stuck, dropped, object-lost, non-finite) or has no way, and
truncated when its steps run out. The observation at the end of an episode is that of its last step. ``info`` then has
``outcome`` and ``summary``, the figures of the episode.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypeAlias

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from numpy.typing import NDArray

from cocarry import _cocarry
from cocarry._cocarry import Error, Lanes, Scenario, World

__all__ = ["CarryEnv", "CarryVectorEnv", "OptionsEnv", "OptionsVectorEnv"]

_Floats: TypeAlias = NDArray[np.float64]

_ENVIRONMENTS = ("environment-1", "environment-2", "environment-3", "environment-4")


def _scenarios(worlds: Any, plant: Literal["point", "kinematic", "rapier"], settings: Mapping[str, Any]) -> list[Scenario]:
    if isinstance(worlds, (str, World)) or hasattr(worlds, "__fspath__"):
        worlds = [worlds]
    return [Scenario(world, plant=plant, **settings) for world in worlds]


_WISHES = ("world", "seed", "alpha", "gamma")


def _wish(options: Mapping[str, Any] | None) -> dict[str, Any]:
    """What ``reset(options=)`` asks for."""
    unknown = [key for key in options or {} if key not in _WISHES]
    if unknown:
        raise Error(f"reset: unknown option {unknown[0]!r}; expected one of: {', '.join(_WISHES)}")
    return dict(options or {})


def _space(lanes: Lanes) -> Any:
    low, high = np.array([bounds for _, bounds in lanes.layout]).T
    return spaces.Box(low, high, dtype=np.float64)


class _Env(gymnasium.Env[_Floats, Any]):
    """What the single environments have in common: a lane."""

    metadata: dict[str, Any] = {"render_modes": ["rgb_array", "html"], "render_fps": 5}  # noqa: RUF012
    _lanes: Lanes

    def __init__(self, lanes: Lanes, render_mode: str | None) -> None:
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise Error(f"render_mode = {render_mode!r}; it must be None or one of: {', '.join(self.metadata['render_modes'])}")
        self._lanes, self.render_mode = lanes, render_mode
        self.observation_space = _space(lanes)
        self._is_seeded = self._is_closed = False
        self._actions: list[list[float]] = []

    @property
    def observation_names(self) -> list[str]:
        """The names of the numbers of an observation, with units; ``[i]`` is the i-th option, joint or point."""
        return [name for name, _ in self._lanes.layout]

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[_Floats, dict[str, Any]]:
        """Begins an episode. ``options`` may set ``world`` (an index), ``seed``, ``alpha`` and ``gamma`` of it."""
        self._check_open()
        wish = _wish(options)
        super().reset(seed=seed)
        if seed is not None:
            self._lanes.seed(0, seed)
        elif not self._is_seeded:
            self._lanes.seed(0, int(self.np_random.integers(2**62)))
        self._is_seeded = True
        self._lanes.reset(**wish)
        self._actions.clear()
        return self._lanes.observations[0].copy(), self._lanes.episode(0)

    def _step(self, actions: NDArray[Any]) -> tuple[_Floats, float, bool, bool, dict[str, Any]]:
        self._check_open()
        lanes = self._lanes
        lanes.step(actions)
        if self.render_mode is not None:
            self._actions.append(np.atleast_1d(actions[0]).astype(np.float64).tolist())
        terminated, truncated = bool(lanes.terminated[0]), bool(lanes.truncated[0])
        info: dict[str, Any] = {}
        if terminated or truncated:
            summary = lanes.summary(0)
            assert summary is not None
            info = {"outcome": summary["outcome"], "summary": summary}
        return lanes.observations[0].copy(), float(lanes.rewards[0]), terminated, truncated, info

    def _check_open(self) -> None:
        if self._is_closed:
            raise _cocarry.ClosedError("the environment is closed; make another one")

    def render(self) -> Any:
        """The world from above with the way walked, (height, width, 3) uint8, or the page of the 3-D player."""
        self._check_open()
        if self.render_mode is None:
            gymnasium.logger.warn('render() needs render_mode="rgb_array" or "html" in gymnasium.make')
            return None
        recording = self._lanes.recording(0, self._actions)
        return _cocarry.player(recording, "episode") if self.render_mode == "html" else _cocarry.picture(recording, 480)

    def close(self) -> None:
        """Ends the environment."""
        self._is_closed = True


class OptionsEnv(_Env):
    """The robot chooses options against a modelled human, on the planning level: ``cocarry/Options-v0``.

    Action: Discrete(n + 1) for n options (of the world with the most): i leads on option i (on the last one where a
    world has fewer), n lets the human lead. Observation: Box, float64: for every option what the paper's robot knows
    (``observation_names``; missing values are 0), then phi(k), whether the human leads, and whether the human takes
    over in this step. Eq. (6) is a function of it.

    worlds: built-in names, files or Worlds. alpha, gamma: of all humans, default drawn. max_episode_steps: truncates.
    Other keywords are settings of Scenario: ``eta=5``, ``human_model="boltzmann(1.0)"``.
    """

    def __init__(
        self,
        worlds: str | World | Sequence[str | World] = _ENVIRONMENTS,
        *,
        alpha: float | None = None,
        gamma: float | None = None,
        objective_weight: float = 1.0,
        subjective_weight: float = 1.0,
        control_weight: float = 0.0,
        max_steps: int | None = None,
        render_mode: str | None = None,
        **settings: Any,
    ) -> None:
        scenarios = _scenarios(worlds, "point", settings)
        weights = (objective_weight, subjective_weight, control_weight)
        lanes = Lanes(1, "options", scenarios, alpha=alpha, gamma=gamma, weights=weights, most_steps=max_steps)
        super().__init__(lanes, render_mode)
        self.action_space = spaces.Discrete(lanes.options + 1)

    def step(self, action: Any) -> tuple[_Floats, float, bool, bool, dict[str, Any]]:
        """One planning step (0.2 s by default)."""
        given = np.asarray(action)
        return self._step(given.reshape(1).astype(np.int64) if given.shape in ((), (1,)) and given.dtype.kind in "iu" else given)


class CarryEnv(_Env):
    """The robot's motion while it carries, on the kinematic or the physical plant: ``cocarry/Carry-v0``.

    The method (``mutual`` by default) decides who leads on which option; the action moves the robot.
    Actions are shares, from -1 to 1, of ``action_limits``; larger ones are clipped.
    ``action="inputs"``: u: rim speeds (m/s), or of an omnidirectional base velocity ahead and to the left (m/s) and
    turning rate (rad/s); then joint rates (rad/s, prismatic m/s), with the robot's limits.
    ``action="reference"``: velocity of the grasp's reference in the grasp's frame, ahead and to the left (limit 1 m/s)
    and turning (2 rad/s), which eq. (7) follows over its horizon.
    Observation: Box, float64, in the frame of the grasp (``observation_names``): joints, last inputs, the goal of the
    grasp, the path ahead for 8 planning steps (0 before the first step), the base and its clearance, who leads, and on
    the physical plant object, hand, and the hand's force and torque.
    """

    def __init__(
        self,
        worlds: str | World | Sequence[str | World] = _ENVIRONMENTS,
        *,
        plant: Literal["kinematic", "rapier"] = "kinematic",
        action: Literal["inputs", "reference"] = "inputs",
        alpha: float | None = None,
        gamma: float | None = None,
        objective_weight: float = 0.0,
        subjective_weight: float = 0.0,
        control_weight: float = 1.0,
        max_steps: int | None = None,
        render_mode: str | None = None,
        **settings: Any,
    ) -> None:
        scenarios = _scenarios(worlds, plant, settings)
        weights = (objective_weight, subjective_weight, control_weight)
        lanes = Lanes(1, action, scenarios, alpha=alpha, gamma=gamma, weights=weights, most_steps=max_steps)
        super().__init__(lanes, render_mode)
        self.action_space = spaces.Box(-1.0, 1.0, lanes.limits.shape, dtype=np.float64)
        self.action_limits = lanes.limits

    def step(self, action: Any) -> tuple[_Floats, float, bool, bool, dict[str, Any]]:
        """One planning step (0.2 s by default)."""
        given = np.asarray(action)
        return self._step(given[np.newaxis].astype(np.float64) if given.dtype.kind in "fiu" else given)


class _VectorEnv(VectorEnv[_Floats, Any, NDArray[Any]]):
    """What the vector environments have in common: lanes in threads of the native module."""

    metadata: dict[str, Any]

    def __init__(self, lanes: Lanes, num_envs: int, autoreset_mode: AutoresetMode, copy: bool) -> None:
        self.num_envs, self._lanes, self._copy = num_envs, lanes, copy
        self.metadata = {"render_modes": [], "autoreset_mode": autoreset_mode}
        self.autoreset_mode, self.render_mode = autoreset_mode, None
        self.single_observation_space = _space(lanes)
        self.observation_space = gymnasium.vector.utils.batch_space(self.single_observation_space, num_envs)
        self._is_seeded = self._is_closed = False
        self._ended = np.zeros(num_envs, dtype=bool)

    def _observations(self) -> _Floats:
        return self._lanes.observations.copy() if self._copy else self._lanes.observations

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[_Floats, dict[str, Any]]:
        """Begins episodes: lane i is seeded with ``seed + i``. ``options`` are those of the single environment, or
        ``reset_mask``, the lanes to reset."""
        self._check_open()
        options = dict(options or {})
        mask = options.pop("reset_mask", None)
        wish = _wish(options)
        if seed is None and not self._is_seeded:
            seed = int(self.np_random.integers(2**62))
        if seed is not None:
            seeds = [seed + i for i in range(self.num_envs)] if isinstance(seed, (int, np.integer)) else list(seed)
            if len(seeds) != self.num_envs:
                raise Error(f"seed has {len(seeds)} numbers; it must be one number or one for each of {self.num_envs} environments")
            for i, one in enumerate(seeds):
                if one is not None:
                    self._lanes.seed(i, int(one))
        self._is_seeded = True
        self._lanes.reset(None if mask is None else [bool(flag) for flag in mask], **wish)
        self._ended[:] = False
        episodes = [self._lanes.episode(i) for i in range(self.num_envs)]
        info: dict[str, Any] = {}
        for key in episodes[0]:
            info[key] = np.array([episode[key] for episode in episodes])
            info[f"_{key}"] = np.ones(self.num_envs, dtype=bool)
        return self._observations(), info

    def step(self, actions: NDArray[Any]) -> tuple[_Floats, _Floats, NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """One planning step (0.2 s by default) of every environment."""
        self._check_open()
        lanes = self._lanes
        lanes.step(actions)
        terminated, truncated = lanes.terminated, lanes.truncated
        info: dict[str, Any] = {}
        ended = terminated | truncated
        if ended.any():
            info = self._endings(ended)
        if not self._copy:
            return lanes.observations, lanes.rewards, terminated, truncated, info
        return lanes.observations.copy(), lanes.rewards.copy(), terminated.copy(), truncated.copy(), info

    def _endings(self, ended: NDArray[np.bool_]) -> dict[str, Any]:
        outcome, summary = (np.full(self.num_envs, None, dtype=object) for _ in range(2))
        final = np.full(self.num_envs, None, dtype=object)
        for i in np.flatnonzero(ended):
            figures = self._lanes.summary(int(i))
            assert figures is not None
            outcome[i], summary[i] = figures["outcome"], figures
            final[i] = self._lanes.last_observation(int(i))
        if self.autoreset_mode == AutoresetMode.SAME_STEP:
            infos = {"outcome": outcome, "_outcome": ended, "summary": summary, "_summary": ended}
            return {"final_obs": final, "_final_obs": ended, "final_info": infos, "_final_info": ended}
        return {"outcome": outcome, "_outcome": ended, "summary": summary, "_summary": ended}

    def _check_open(self) -> None:
        if self._is_closed:
            raise _cocarry.ClosedError("the environment is closed; make another one")

    def close_extras(self, **kwargs: Any) -> None:
        """Ends the environment."""
        self._is_closed = True


_AUTORESETS = {AutoresetMode.NEXT_STEP: "next-step", AutoresetMode.SAME_STEP: "same-step"}


def _mode(given: str | AutoresetMode) -> AutoresetMode:
    mode = next((mode for mode in _AUTORESETS if given in (mode, mode.value, mode.name)), None)
    if mode is None:
        raise Error(f"autoreset_mode = {given!r}; it must be NEXT_STEP or SAME_STEP")
    return mode


class OptionsVectorEnv(_VectorEnv):
    """Many ``cocarry/Options-v0`` in the native module's threads: equal to single ones, bit for bit.

    autoreset_mode: NEXT_STEP or SAME_STEP. threads: default all. copy: False returns the same arrays in every step.
    """

    def __init__(
        self,
        num_envs: int = 1,
        worlds: str | World | Sequence[str | World] = _ENVIRONMENTS,
        *,
        alpha: float | None = None,
        gamma: float | None = None,
        objective_weight: float = 1.0,
        subjective_weight: float = 1.0,
        control_weight: float = 0.0,
        max_steps: int | None = None,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        threads: int | None = None,
        copy: bool = True,
        **settings: Any,
    ) -> None:
        mode, scenarios = _mode(autoreset_mode), _scenarios(worlds, "point", settings)
        lanes = Lanes(
            num_envs,
            "options",
            scenarios,
            alpha=alpha,
            gamma=gamma,
            weights=(objective_weight, subjective_weight, control_weight),
            most_steps=max_steps,
            autoreset=_AUTORESETS[mode],
            threads=threads,
        )
        super().__init__(lanes, num_envs, mode, copy)
        self.single_action_space = spaces.Discrete(lanes.options + 1)
        self.action_space = gymnasium.vector.utils.batch_space(self.single_action_space, num_envs)


class CarryVectorEnv(_VectorEnv):
    """Many ``cocarry/Carry-v0`` in the native module's threads: equal to single ones, bit for bit."""

    def __init__(
        self,
        num_envs: int = 1,
        worlds: str | World | Sequence[str | World] = _ENVIRONMENTS,
        *,
        plant: Literal["kinematic", "rapier"] = "kinematic",
        action: Literal["inputs", "reference"] = "inputs",
        alpha: float | None = None,
        gamma: float | None = None,
        objective_weight: float = 0.0,
        subjective_weight: float = 0.0,
        control_weight: float = 1.0,
        max_steps: int | None = None,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        threads: int | None = None,
        copy: bool = True,
        **settings: Any,
    ) -> None:
        mode, scenarios = _mode(autoreset_mode), _scenarios(worlds, plant, settings)
        lanes = Lanes(
            num_envs,
            action,
            scenarios,
            alpha=alpha,
            gamma=gamma,
            weights=(objective_weight, subjective_weight, control_weight),
            most_steps=max_steps,
            autoreset=_AUTORESETS[mode],
            threads=threads,
        )
        super().__init__(lanes, num_envs, mode, copy)
        self.single_action_space = spaces.Box(-1.0, 1.0, lanes.limits.shape, dtype=np.float64)
        self.action_limits = lanes.limits
        self.action_space = gymnasium.vector.utils.batch_space(self.single_action_space, num_envs)


for _name, _single, _vector in (("Options", "OptionsEnv", "OptionsVectorEnv"), ("Carry", "CarryEnv", "CarryVectorEnv")):
    if f"cocarry/{_name}-v0" not in gymnasium.registry:
        gymnasium.register(
            f"cocarry/{_name}-v0",
            entry_point=f"cocarry.environments:{_single}",
            vector_entry_point=f"cocarry.environments:{_vector}",
        )
