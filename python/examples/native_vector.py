"""A native vector environment of cocarry as a ``VecEnv`` of Stable-Baselines3: one call steps all its episodes."""

from __future__ import annotations

import numpy as np
from gymnasium.vector import VectorEnv
from stable_baselines3.common.vec_env import VecEnv


class NativeVector(VecEnv):
    """``inner``, made by ``gymnasium.make_vec(..., autoreset_mode="SameStep")``, whose first reset has this seed."""

    def __init__(self, inner: VectorEnv, seed: int) -> None:
        self.inner, self.first_seed, self.render_mode = inner, seed, None
        super().__init__(inner.num_envs, inner.single_observation_space, inner.single_action_space)

    def reset(self):
        return self.inner.reset(seed=self.first_seed)[0]

    def step_async(self, actions):
        self.actions = actions

    def step_wait(self):
        observations, rewards, terminated, truncated, more = self.inner.step(self.actions)
        infos = [{} for _ in range(self.num_envs)]
        for i in np.flatnonzero(terminated | truncated):
            infos[i] = {"terminal_observation": more["final_obs"][i], "TimeLimit.truncated": bool(truncated[i])}
        return observations, rewards, terminated | truncated, infos

    def close(self):
        self.inner.close()

    def get_attr(self, name, indices=None):
        return [getattr(self, name)] * self.num_envs

    def set_attr(self, name, value, indices=None):
        raise NotImplementedError

    def env_method(self, name, *arguments, indices=None, **keywords):
        raise NotImplementedError

    def env_is_wrapped(self, wrapper, indices=None):
        return [False] * self.num_envs
