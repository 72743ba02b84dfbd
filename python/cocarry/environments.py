"""Environments for learners: Gymnasium's ``cocarry/Options-v0`` and ``cocarry/Carry-v1``.

``import cocarry`` registers them where Gymnasium is installed; an id with the module before it needs no import::

    import gymnasium

    environment = gymnasium.make("cocarry:cocarry/Options-v0", worlds=["environment-4"])
    vector = gymnasium.make_vec("cocarry:cocarry/Options-v0", num_envs=64)

An episode draws a world, a seed, and a human of that seed from the robot's belief. An environment's generator is
seeded by ``reset(seed=)`` and draws every later episode too. A change of any result raises the ids' version.

The cost of a step is ``objective_weight`` J plus ``subjective_weight`` J^ plus ``control_weight`` C: the objective cost of
the option executed (m, eq. 1), its subjective cost to this human (cost units, eq. 2), and the control cost of the step
(Sec. V-C). Summed over an episode, these are the paper's figures. The reward of ``cocarry/Options-v0`` is minus the cost;
``CarryEnv`` says what an episode of ``cocarry/Carry-v1`` is charged that ends without arriving.

An episode is terminated when it arrives, fails (collided, stuck, dropped, object-lost, non-finite) or has no way, and
truncated when its steps run out. ``cocarry/Carry-v1`` charges that like a failure, so that it terminates the episode, and only
``max_episode_steps`` truncates one. The observation at the end of an episode is that of its last step. ``info`` then has
``outcome`` and ``summary``, the figures of the episode. After a reset it has the episode's ``world`` (an index),
``world_name``, ``seed``, ``alpha``, ``gamma`` and number of ``options``.

Environments can be copied (``copy.deepcopy``) and pickled in mid-episode; the copy continues with the same bits.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Literal, TypeAlias

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from numpy.typing import NDArray

from cocarry import _arguments, _cocarry
from cocarry._cocarry import Error, Lanes, Scenario, World
from cocarry._register import register

__all__ = ["CarryEnv", "CarryVectorEnv", "OptionsEnv", "OptionsVectorEnv"]

_Floats: TypeAlias = NDArray[np.float64]
_Worlds: TypeAlias = str | World | Sequence[str | World]

_ENVIRONMENTS = ("environment-1", "environment-2", "environment-3", "environment-4")

_MODES = ("rgb_array", "html")

_RESIDUAL_SCALE = 0.1
"""What an action of 1 stands for by default as a share of the robot's limits, where it is added to the built-in controller."""


def _scenarios(worlds: Any, plant: Literal["point", "kinematic", "rapier"], settings: Mapping[str, Any]) -> list[Scenario]:
    if isinstance(worlds, (str, World)) or hasattr(worlds, "__fspath__"):
        worlds = [worlds]
    try:
        given = list(worlds)
    except TypeError:
        raise Error(f"worlds = {worlds!r}; it must be a world or a list of worlds: names, files or cocarry.World") from None
    if "world" in settings:
        raise Error(f"world = {settings['world']!r}: unknown keyword `world`; did you mean `worlds`?")
    if "plant" in settings:
        raise Error(f'plant = {settings["plant"]!r}: this environment is of the planning level, plant="point"; cocarry/Carry-v1 has the others')
    return [Scenario(world, plant=plant, **settings) for world in given]


_WISHES = ("world", "seed", "alpha", "gamma")


def _wish(options: Mapping[str, Any] | None) -> dict[str, Any]:
    """What ``reset(options=)`` asks for."""
    wish = {} if options is None else dict(_arguments.mapping("options", options))
    unknown = [key for key in wish if key not in _WISHES]
    if unknown:
        raise Error(f"reset: unknown option {unknown[0]!r}; expected one of: {', '.join(_WISHES)}")
    return wish


def _seed(seed: Any) -> int:
    """A seed of ``reset``, which Gymnasium wants whole."""
    return _arguments.whole("seed", seed, 0)


def _space(lanes: Lanes) -> Any:
    low, high = np.array([bounds for _, _, bounds in lanes.layout]).T
    return spaces.Box(low, high, dtype=np.float64)


def _check_render_mode(render_mode: Any) -> None:
    if render_mode is not None and (not isinstance(render_mode, str) or render_mode not in _MODES):
        raise Error(f"render_mode = {render_mode!r}; it must be None or one of: {', '.join(_MODES)}")


class _Resumable:
    """What has lanes: named numbers, pictures, and copies in mid-episode."""

    _lanes: Lanes
    _made: dict[str, Any]
    render_mode: str | None

    def _make(self, num_envs: int, task: str, worlds: Any, plant: Any, settings: Mapping[str, Any], **keywords: Any) -> Lanes:
        # the changes are drawn for every episode: those of the scenarios are of one seed
        changes = settings.get("preference_changes")
        scenarios = _scenarios(worlds, plant, settings)
        self._made = {"num_envs": num_envs, "task": task, "scenarios": scenarios, "preference_changes": changes, **keywords}
        self._lanes = Lanes(**self._made)
        return self._lanes

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_lanes": self._lanes.save()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._lanes = Lanes(**self._made)
        self._lanes.restore(state["_lanes"])

    @property
    def observation_names(self) -> list[str]:
        """The names of the numbers of an observation, which end in their units; ``[...]`` is an option's or a point's
        index, or the name of a joint or of an input of the base."""
        return [name for name, _, _ in self._lanes.layout]

    @property
    def observation_units(self) -> list[str]:
        """The units of the numbers of an observation: m, rad, m/s, rad/s, N, Nm, cost units; ``1`` for shares, probabilities
        and flags."""
        return [unit for _, unit, _ in self._lanes.layout]

    def _picture(self, lane: int, actions: list[list[float]]) -> Any:
        recording = self._lanes.recording(lane, actions)
        return _cocarry.player(recording, "episode") if self.render_mode == "html" else _cocarry.picture(recording, 480)


class _Env(_Resumable, gymnasium.Env[_Floats, Any]):
    """What the single environments have in common: a lane."""

    metadata: ClassVar[dict[str, Any]] = {"render_modes": list(_MODES), "render_fps": 5}  # type: ignore[misc]

    def __init__(self, render_mode: str | None) -> None:
        _check_render_mode(render_mode)
        self.render_mode = render_mode
        self.observation_space = _space(self._lanes)
        self._is_seeded = self._is_closed = False
        self._actions: list[list[float]] = []

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[_Floats, dict[str, Any]]:
        """Begins an episode. ``options`` may set ``world`` (an index or a name), ``seed``, ``alpha`` and ``gamma`` of it."""
        self._check_open()
        wish = _wish(options)
        chosen = None if seed is None else _seed(seed)
        super().reset(seed=chosen)
        if chosen is not None:
            self._lanes.seed(0, chosen)
        elif not self._is_seeded:
            self._lanes.seed(0, int(self.np_random.integers(2**62)))
        self._is_seeded = True
        self._lanes.reset(**wish)
        self._actions.clear()
        return self._lanes.observations[0].copy(), {**self._lanes.episode(0), **self._told()}

    def _told(self) -> dict[str, Any]:
        """What ``info`` has in every step."""
        return {}

    def _step(self, actions: NDArray[Any]) -> tuple[_Floats, float, bool, bool, dict[str, Any]]:
        self._check_open()
        lanes = self._lanes
        lanes.step(actions)
        if self.render_mode is not None:
            self._actions.append(np.atleast_1d(actions[0]).astype(np.float64).tolist())
        terminated, truncated = bool(lanes.terminated[0]), bool(lanes.truncated[0])
        info = self._told()
        if terminated or truncated:
            summary = lanes.summary(0)
            assert summary is not None
            info |= {"outcome": summary["outcome"], "summary": summary}
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
        return self._picture(0, self._actions)

    def close(self) -> None:
        """Ends the environment."""
        self._is_closed = True


class OptionsEnv(_Env):
    """The robot chooses options against a modelled human, on the planning level: ``cocarry/Options-v0``.

    Action: Discrete(n + 1) for n options (of the world with the most): i leads on option i (on the last one where a
    world has fewer), n lets the human lead. ``info["action_mask"]``, (n + 1,) int8, is 0 for options that the episode's
    world does not have; ``action_space.sample(mask)`` takes it, and ``action_masks()`` has it for MaskablePPO.
    Observation: Box, float64: for every option what the paper's robot knows
    (``observation_names``; missing values are 0), then phi(k), whether the human leads, and whether the human takes
    over in this step. Eq. (6) is a function of it. Where worlds differ in their number of options, every option also has
    ``available``, 1 if the episode's world has it.

    worlds: built-in names, files or Worlds. alpha, gamma: of all humans, default drawn. max_steps, max_episode_steps:
    truncate. Other keywords are settings of Scenario: ``eta=5``, ``human_model="boltzmann(1.0)"``.
    """

    def __init__(
        self,
        worlds: _Worlds = _ENVIRONMENTS,
        *,
        alpha: float | None = None,
        gamma: float | None = None,
        objective_weight: float = 1.0,
        subjective_weight: float = 1.0,
        control_weight: float = 0.0,
        max_steps: int | None = None,
        max_episode_steps: int | None = None,
        render_mode: str | None = None,
        **settings: Any,
    ) -> None:
        lanes = self._make(
            1, "options", worlds, "point", settings, alpha=alpha, gamma=gamma, max_steps=max_steps,
            weights=(objective_weight, subjective_weight, control_weight), max_episode_steps=max_episode_steps,
        )  # fmt: skip
        super().__init__(render_mode)
        self.action_space = spaces.Discrete(lanes.options + 1)

    def action_masks(self) -> NDArray[np.bool_]:
        """Which actions the episode's world has, (n + 1,)."""
        mask: NDArray[np.bool_] = self._lanes.action_masks[0] == 1
        return mask

    def _told(self) -> dict[str, Any]:
        return {"action_mask": self._lanes.action_masks[0]}

    def step(self, action: Any) -> tuple[_Floats, float, bool, bool, dict[str, Any]]:
        """One planning step (0.2 s by default)."""
        given = np.asarray(action)
        return self._step(given.reshape(1).astype(np.int64) if given.shape in ((), (1,)) and given.dtype.kind in "iu" else given)


def _carrying(
    plant: Literal["kinematic", "rapier"], action: str, scale: float | None, most: float | None, prices_ending: bool, tells: bool
) -> dict[str, Any]:
    """What both environments that carry tell their lanes."""
    _arguments.flag("charges_failure", prices_ending)
    _arguments.flag("built_in", tells)
    if not isinstance(action, str) or action not in ("inputs", "reference", "residual"):
        raise Error(f"action = {action!r}; it must be one of: inputs, reference, residual")
    if scale is None:
        scale = _RESIDUAL_SCALE if action == "residual" else 1.0
    return {"action_scale": scale, "most_step_cost": most, "prices_ending": prices_ending, "tells_built_in": tells}


class CarryEnv(_Env):
    """The robot's motion while it carries, on the kinematic or the physical plant: ``cocarry/Carry-v1``.

    The method (``mutual`` by default) decides who leads on which option; the action moves the robot.
    Actions are shares, from -1 to 1, of ``action_limits`` (``action_names``); others raise ActionError.
    ``action="inputs"``: u: rim speeds (m/s), or of an omnidirectional base velocity ahead and to the left (m/s) and
    turning rate (rad/s); then joint rates (rad/s, prismatic m/s), with the robot's limits.
    ``action="reference"``: velocity of the grasp's reference in the grasp's frame, ahead and to the left (limit 1 m/s)
    and turning (2 rad/s), which eq. (7) follows over its horizon.
    ``action="residual"``: what is added to the inputs of the built-in controller (eqs. 8 and 7), within the robot's
    limits; 0 is the built-in controller, bit for bit. An action of 1 is a tenth of the limits, unless ``action_scale``
    says otherwise. The other actions have to keep up with a human who walks on: standing still loses the object in
    three steps, and so do random inputs.

    ``info["built_in_action"]`` is the action that the built-in controller would take next, cut to the box, and
    ``info["built_in_inputs"]`` its inputs u with the rates of eq. (8) (m/s, rad/s), both in the first control period;
    ``built_in=False`` leaves them out, which makes steps on the kinematic plant several times as fast.

    Reward: minus the cost of the step (by default C), at most m = ``most_step_cost``, by default ten times the cost at which
    the object is lost: 10 ``control_weight`` Q (0.1 m)^2, plus the largest J and J^ of the start by their weights. An episode
    takes at most N = ``max_steps`` steps, by default 3 times the steps of the longest option. One that ends after k steps
    without arriving, or has not arrived after N, is charged m (2 N - k) at its end. So ending is never better than going
    on, in whichever way and with whichever discount: whoever goes on pays at most m a step, and at most m (2 N - k)
    in all. And whoever arrives has paid at most m N, which whoever does not arrive is charged at the end alone. (``time_left``
    of an observation is the share of N that is left. A wrapper's own limit is not an end of the task, and
    charges nothing; nor does ``max_episode_steps``.)

    Observation: Box, float64, in the frame of the grasp (``observation_names``): joints, last inputs, the goal of the
    grasp, the path ahead for 8 planning steps (0 before the first step), the base and its clearance, who leads, on
    the physical plant object, hand, and the hand's force and torque, and ``time_left``.

    ``cocarry/Carry-v0`` has the reward -C, which charges nothing for a lost object, no ``time_left``, and no built-in
    action.
    """

    def __init__(
        self,
        worlds: _Worlds = _ENVIRONMENTS,
        *,
        plant: Literal["kinematic", "rapier"] = "kinematic",
        action: Literal["inputs", "reference", "residual"] = "inputs",
        action_scale: float | None = None,
        alpha: float | None = None,
        gamma: float | None = None,
        objective_weight: float = 0.0,
        subjective_weight: float = 0.0,
        control_weight: float = 1.0,
        most_step_cost: float | None = None,
        charges_failure: bool = True,
        built_in: bool = True,
        max_steps: int | None = None,
        max_episode_steps: int | None = None,
        render_mode: str | None = None,
        **settings: Any,
    ) -> None:
        carrying = _carrying(plant, action, action_scale, most_step_cost, charges_failure, built_in)
        lanes = self._make(
            1, action, worlds, plant, settings, alpha=alpha, gamma=gamma, max_steps=max_steps,
            weights=(objective_weight, subjective_weight, control_weight), max_episode_steps=max_episode_steps, **carrying,
        )  # fmt: skip
        super().__init__(render_mode)
        self.action_space = spaces.Box(-1.0, 1.0, lanes.limits.shape, dtype=np.float64)
        self.action_limits = lanes.limits

    @property
    def action_names(self) -> list[str]:
        """The names of the numbers of an action, which end in the units of ``action_limits``."""
        return [name for name, _ in self._lanes.action_layout]

    def _told(self) -> dict[str, Any]:
        told = self._lanes.built_in(0)
        return {} if told is None else {"built_in_action": told[0], "built_in_inputs": told[1]}

    def step(self, action: Any) -> tuple[_Floats, float, bool, bool, dict[str, Any]]:
        """One planning step (0.2 s by default)."""
        given = np.asarray(action)
        return self._step(given[np.newaxis].astype(np.float64) if given.dtype.kind in "fiu" else given)


class _VectorEnv(_Resumable, VectorEnv[_Floats, Any, NDArray[Any]]):
    """What the vector environments have in common: lanes in threads of the native module."""

    metadata: dict[str, Any]

    def __init__(self, num_envs: int, autoreset_mode: AutoresetMode, copy: bool, render_mode: str | None) -> None:
        _check_render_mode(render_mode)
        self.num_envs, self._copy, self.render_mode = num_envs, copy, render_mode
        self.metadata = {"render_modes": list(_MODES), "render_fps": 5, "autoreset_mode": autoreset_mode}
        self.autoreset_mode = autoreset_mode
        self.single_observation_space = _space(self._lanes)
        self.observation_space = gymnasium.vector.utils.batch_space(self.single_observation_space, num_envs)
        self._is_seeded = self._is_closed = False
        self._ended = np.zeros(num_envs, dtype=bool)
        self._actions: list[list[list[float]]] = [[] for _ in range(num_envs)]

    def _observations(self) -> _Floats:
        return self._lanes.observations.copy() if self._copy else self._lanes.observations

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[_Floats, dict[str, Any]]:
        """Begins episodes: lane i is seeded with ``seed + i``. ``options`` are those of the single environment, and
        ``reset_mask``, the lanes to reset; ``info`` then is about these."""
        self._check_open()
        options = {} if options is None else dict(_arguments.mapping("options", options))
        given = options.pop("reset_mask", None)
        wish = _wish(options)
        mask = np.ones(self.num_envs, dtype=bool) if given is None else self._mask(given)
        if seed is None and not self._is_seeded:
            seed = int(self.np_random.integers(2**62))
        if seed is not None:
            is_one = isinstance(seed, str) or not isinstance(seed, (Sequence, np.ndarray)) or getattr(seed, "ndim", 1) == 0
            seeds = [_seed(seed) + i for i in range(self.num_envs)] if is_one else list(seed)  # type: ignore[arg-type]
            if len(seeds) != self.num_envs:
                raise Error(f"seed has {len(seeds)} numbers; it must be one number or one for each of {self.num_envs} environments")
            for i in np.flatnonzero(mask):
                if seeds[i] is not None:
                    self._lanes.seed(int(i), _seed(seeds[i]))
        self._is_seeded = True
        self._lanes.reset(mask.tolist(), **wish)
        self._ended[mask] = False
        for i in np.flatnonzero(mask):
            self._actions[i].clear()
        info: dict[str, Any] = {}
        episodes = {i: self._lanes.episode(int(i)) for i in np.flatnonzero(mask)}
        for key, first in next(iter(episodes.values())).items():
            is_text = isinstance(first, str)
            info[key] = np.full(self.num_envs, None if is_text else 0, dtype=object if is_text else type(first))
            info[key][mask] = [episode[key] for episode in episodes.values()]
            info[f"_{key}"] = mask.copy()
        return self._observations(), info | self._told(mask)

    def _mask(self, given: Any) -> NDArray[np.bool_]:
        mask = np.asarray(given)
        if mask.dtype != np.bool_ or mask.shape != (self.num_envs,) or not mask.any():
            raise Error(f"reset_mask = {given!r}; it must be {self.num_envs} flags (bool), at least one of them True")
        return mask

    def _told(self, mask: NDArray[np.bool_]) -> dict[str, Any]:
        """What ``info`` has in every step of these lanes."""
        return {}

    def step(self, actions: NDArray[Any]) -> tuple[_Floats, _Floats, NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """One planning step (0.2 s by default) of every environment."""
        self._check_open()
        lanes = self._lanes
        given = self._given(np.asarray(actions))
        lanes.step(given)
        terminated, truncated = lanes.terminated, lanes.truncated
        ended = terminated | truncated
        self._keep(given, ended)
        info = self._told(np.ones(self.num_envs, dtype=bool))
        if ended.any():
            info |= self._endings(ended)
        if not self._copy:
            return lanes.observations, lanes.rewards, terminated, truncated, info
        return lanes.observations.copy(), lanes.rewards.copy(), terminated.copy(), truncated.copy(), info

    def _given(self, actions: NDArray[Any]) -> NDArray[Any]:
        """Actions as the native module takes them."""
        return actions

    def _keep(self, given: NDArray[Any], ended: NDArray[np.bool_]) -> None:
        """Keeps the actions of every lane's episode, for pictures."""
        if self.render_mode is not None:
            is_same_step = self.autoreset_mode == AutoresetMode.SAME_STEP
            for i, actions in enumerate(self._actions):
                if self._ended[i] or (is_same_step and ended[i]):
                    actions.clear()
                else:
                    actions.append(np.atleast_1d(given[i]).astype(np.float64).tolist())
            if self.autoreset_mode == AutoresetMode.NEXT_STEP:
                self._ended[:] = ended

    def _endings(self, ended: NDArray[np.bool_]) -> dict[str, Any]:
        outcome, summary = (np.full(self.num_envs, None, dtype=object) for _ in range(2))
        for i in np.flatnonzero(ended):
            figures = self._lanes.summary(int(i))
            assert figures is not None
            outcome[i], summary[i] = figures["outcome"], figures
        if self.autoreset_mode == AutoresetMode.SAME_STEP:
            final = np.full(self.num_envs, None, dtype=object)
            for i in np.flatnonzero(ended):
                final[i] = self._lanes.last_observation(int(i))
            infos = {"outcome": outcome, "_outcome": ended, "summary": summary, "_summary": ended}
            return {"final_obs": final, "_final_obs": ended, "final_info": infos, "_final_info": ended}
        return {"outcome": outcome, "_outcome": ended, "summary": summary, "_summary": ended}

    def render(self) -> tuple[Any, ...] | None:
        """A picture or a page for every environment, as a single one has it."""
        self._check_open()
        if self.render_mode is None:
            gymnasium.logger.warn('render() needs render_mode="rgb_array" or "html" in gymnasium.make_vec')
            return None
        return tuple(self._picture(i, actions) for i, actions in enumerate(self._actions))

    def _check_open(self) -> None:
        if self._is_closed:
            raise _cocarry.ClosedError("the environment is closed; make another one")

    def close_extras(self, **kwargs: Any) -> None:
        """Ends the environment."""
        self._is_closed = True


_AUTORESETS = {AutoresetMode.NEXT_STEP: "next-step", AutoresetMode.SAME_STEP: "same-step", AutoresetMode.DISABLED: None}


def _mode(given: str | AutoresetMode) -> AutoresetMode:
    is_named = isinstance(given, (str, AutoresetMode))
    mode = next((mode for mode in _AUTORESETS if is_named and given in (mode, mode.value, mode.name)), None)
    if mode is None:
        raise Error(f"autoreset_mode = {given!r}; it must be NEXT_STEP, SAME_STEP or DISABLED")
    return mode


class OptionsVectorEnv(_VectorEnv):
    """Many ``cocarry/Options-v0`` in the native module's threads: equal to single ones, bit for bit.

    autoreset_mode: NEXT_STEP, SAME_STEP or DISABLED (reset ended lanes by ``reset_mask``). threads: default all.
    copy: False returns the same arrays in every step. The other keywords are those of OptionsEnv.
    """

    def __init__(
        self,
        num_envs: int = 1,
        worlds: _Worlds = _ENVIRONMENTS,
        *,
        alpha: float | None = None,
        gamma: float | None = None,
        objective_weight: float = 1.0,
        subjective_weight: float = 1.0,
        control_weight: float = 0.0,
        max_steps: int | None = None,
        max_episode_steps: int | None = None,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        threads: int | None = None,
        copy: bool = True,
        render_mode: str | None = None,
        **settings: Any,
    ) -> None:
        mode = _mode(autoreset_mode)
        lanes = self._make(
            num_envs, "options", worlds, "point", settings, alpha=alpha, gamma=gamma, max_steps=max_steps,
            weights=(objective_weight, subjective_weight, control_weight), max_episode_steps=max_episode_steps,
            autoreset=_AUTORESETS[mode], threads=threads,
        )  # fmt: skip
        super().__init__(num_envs, mode, copy, render_mode)
        self.single_action_space = spaces.Discrete(lanes.options + 1)
        self.action_space = gymnasium.vector.utils.batch_space(self.single_action_space, num_envs)

    def action_masks(self) -> NDArray[np.bool_]:
        """Which actions the world of every lane's episode has, (num_envs, n + 1)."""
        masks: NDArray[np.bool_] = self._lanes.action_masks == 1
        return masks

    def _told(self, mask: NDArray[np.bool_]) -> dict[str, Any]:
        return {"action_mask": self._lanes.action_masks, "_action_mask": mask.copy()}

    def _given(self, actions: NDArray[Any]) -> NDArray[Any]:
        return actions.astype(np.int64) if actions.dtype.kind in "iu" else actions


class CarryVectorEnv(_VectorEnv):
    """Many ``cocarry/Carry-v1`` in the native module's threads: equal to single ones, bit for bit.

    The keywords are those of CarryEnv and OptionsVectorEnv.
    """

    def __init__(
        self,
        num_envs: int = 1,
        worlds: _Worlds = _ENVIRONMENTS,
        *,
        plant: Literal["kinematic", "rapier"] = "kinematic",
        action: Literal["inputs", "reference", "residual"] = "inputs",
        action_scale: float | None = None,
        alpha: float | None = None,
        gamma: float | None = None,
        objective_weight: float = 0.0,
        subjective_weight: float = 0.0,
        control_weight: float = 1.0,
        most_step_cost: float | None = None,
        charges_failure: bool = True,
        built_in: bool = True,
        max_steps: int | None = None,
        max_episode_steps: int | None = None,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        threads: int | None = None,
        copy: bool = True,
        render_mode: str | None = None,
        **settings: Any,
    ) -> None:
        mode, carrying = _mode(autoreset_mode), _carrying(plant, action, action_scale, most_step_cost, charges_failure, built_in)
        lanes = self._make(
            num_envs, action, worlds, plant, settings, alpha=alpha, gamma=gamma, max_steps=max_steps,
            weights=(objective_weight, subjective_weight, control_weight), max_episode_steps=max_episode_steps,
            autoreset=_AUTORESETS[mode], threads=threads, **carrying,
        )  # fmt: skip
        super().__init__(num_envs, mode, copy, render_mode)
        self.single_action_space = spaces.Box(-1.0, 1.0, lanes.limits.shape, dtype=np.float64)
        self.action_limits = lanes.limits
        self.action_space = gymnasium.vector.utils.batch_space(self.single_action_space, num_envs)

    @property
    def action_names(self) -> list[str]:
        """The names of the numbers of an action, which end in the units of ``action_limits``."""
        return [name for name, _ in self._lanes.action_layout]

    def _told(self, mask: NDArray[np.bool_]) -> dict[str, Any]:
        told = [self._lanes.built_in(i) for i in range(self.num_envs)] if self._made["tells_built_in"] else []
        if not told:
            return {}
        actions, inputs = (np.stack([one[part] for one in told if one is not None]) for part in (0, 1))
        masks = {"_built_in_action": mask.copy(), "_built_in_inputs": mask.copy()}
        return {"built_in_action": actions, "built_in_inputs": inputs, **masks}

    def _given(self, actions: NDArray[Any]) -> NDArray[Any]:
        return actions.astype(np.float64) if actions.dtype.kind in "fiu" else actions


register(gymnasium)
