"""Behaviour cloning: a network learns eq. (6) from 500 episodes of a LeRobot data set, and carries with humans it never saw.

    pip install "./python[datasets]"
    python python/examples/clone.py

The data set is that of ``cocarry.datasets.to_lerobot``: ``mutual`` in all four environments on the planning level. The
network (numpy, two layers of 64) sees ``observation.environment_state`` and gives ``action``: the option on which the robot
leads, or to let the human lead. It then is a custom policy, for seeds from 2^33 on; training has those from 0 on. The second
comparison has humans that training does not have at all: their choices are noisy.
"""

from __future__ import annotations

import argparse
import json
import os
import pathlib
import tempfile
import time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # its matrices are small: threads only get in each other's way

import numpy as np
import pyarrow.parquet as parquet

import cocarry
from cocarry.datasets import to_lerobot

WORLDS = [f"environment-{i}" for i in range(1, 5)]
ETAS = [5, 10.5, 15]
HELD_OUT = 2**33


class Clone(cocarry.Policy):
    """The option, or to follow, that the network finds most probable."""

    def __init__(self, keys, mean, scale, layers):
        self.keys, self.mean, self.scale, self.layers = keys, mean, scale, layers

    def decide(self, view):
        observation = np.zeros_like(self.mean)
        options = observation[:-3].reshape(-1, len(self.keys) + 1)
        for column, key in enumerate(self.keys):
            options[: len(view), column] = np.nan_to_num(view[key])
        if view.executed is not None:
            options[view.executed, -1] = 1
        observation[-3:] = view.stubbornness, view.mode == "human-led", view.stance == "take-over"
        scores = forward(self.layers, ((observation - self.mean) / self.scale)[np.newaxis])[-1][0]
        scores[len(view) : -1] = -np.inf  # options that this world does not have
        best = int(scores.argmax())
        return None if best == len(options) else best


def forward(layers, inputs):
    """The inputs, the hidden layers and the scores."""
    found = [inputs]
    for index, (weights, bias) in enumerate(layers):
        inputs = inputs @ weights + bias
        found.append(np.maximum(inputs, 0) if index < len(layers) - 1 else inputs)
        inputs = found[-1]
    return found


def train(inputs, labels, classes, epochs, seed=0):
    """Minimises the cross-entropy with Adam; the steps get smaller along a cosine."""
    rng = np.random.default_rng(seed)
    sizes = [inputs.shape[1], 64, 64, classes]
    layers = [[rng.normal(0, np.sqrt(2 / a), (a, b)), np.zeros(b)] for a, b in zip(sizes, sizes[1:])]
    moments = [[[np.zeros_like(p), np.zeros_like(p)] for p in layer] for layer in layers]
    batch = 256
    count = epochs * (len(inputs) // batch)
    for step in range(count):
        if step % (len(inputs) // batch) == 0:
            order = rng.permutation(len(inputs))
        rows = order[step % (len(inputs) // batch) * batch :][:batch]
        found = forward(layers, inputs[rows])
        shares = np.exp(found[-1] - found[-1].max(axis=1, keepdims=True))
        slope = shares / shares.sum(axis=1, keepdims=True)
        slope[np.arange(batch), labels[rows]] -= 1
        slope /= batch
        rate = 1e-3 * (1 + np.cos(np.pi * step / count)) + 1e-5
        for layer, kept, values in zip(layers[::-1], moments[::-1], found[-2::-1]):
            slopes = [values.T @ slope, slope.sum(axis=0)]
            slope = slope @ layer[0].T * (values > 0)
            for parameter, (first, second), change in zip(layer, kept, slopes):
                first += 0.1 * (change - first)
                second += 0.001 * (change**2 - second)
                corrected = first / (1 - 0.9 ** (step + 1)), second / (1 - 0.999 ** (step + 1))
                parameter -= rate * corrected[0] / (np.sqrt(corrected[1]) + 1e-8)
    return layers


def load(folder):
    """Observations, actions, their names, and mean and standard deviation of the observations."""
    table = parquet.read_table(folder / "data", columns=["observation.environment_state", "action"])
    observations = np.stack(table["observation.environment_state"].to_numpy())
    stats = json.loads((folder / "meta" / "stats.json").read_text())["observation.environment_state"]
    features = json.loads((folder / "meta" / "info.json").read_text())["features"]
    names = features["observation.environment_state"]["names"]
    return observations, table["action"].to_numpy(), names, np.array(stats["mean"]), np.array(stats["std"])


def export(folder, first, count):
    scenarios = [
        cocarry.Scenario(WORLDS[i % 4], plant="point", seed=first + i, eta=ETAS[i // 4 % 3]) for i in range(count)
    ]
    return to_lerobot(scenarios, folder)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--episodes", type=int, default=500, help="exported for training")
    parser.add_argument("--humans", type=int, default=100, help="held-out seeds, each in four environments")
    parser.add_argument("--epochs", type=int, default=10)
    given = parser.parse_args(arguments)

    begin = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        data = export(pathlib.Path(folder) / "carried", 0, given.episodes)
        observations, actions, names, mean, std = load(data)
    scale = np.where(std > 1e-9, std, 1.0)
    exported = time.perf_counter()
    options = sum(name.startswith("executed[") for name in names)
    layers = train((observations - mean) / scale, actions, options + 1, given.epochs)
    keys = [name.removesuffix("[0]") for name in names if name.endswith("[0]") and not name.startswith("executed")]
    clones = {"clone": Clone(keys, mean, scale, layers), "untrained": Clone(keys, mean, scale, train(observations, actions, options + 1, 0))}
    print(f"{given.episodes} episodes, {len(actions)} frames: exported in {exported - begin:.0f} s, trained in {time.perf_counter() - exported:.0f} s")

    for name, model in (("humans as in training", "preference"), ("noisy humans", "boltzmann(0.8)")):
        print(name)
        compare(clones, given.humans, model)


def compare(clones, humans, model):
    """The networks next to eq. (6), with the same humans."""
    seeds = {"first": HELD_OUT, "last": HELD_OUT + humans - 1}
    study = {"worlds": WORLDS, "plants": "point", "methods": "mutual", "seeds": seeds, "eta": ETAS, "human_model": model}
    mutual = cocarry.sweep(study)
    told("mutual", mutual, "")
    for name, clone in clones.items():
        table = cocarry.sweep(study, policy=clone)
        assert (table["seed"] == mutual["seed"]).all() and (table["world"] == mutual["world"]).all()
        paired = cost(table) - cost(mutual)
        means = np.array([paired[mutual["seed"] == seed].mean() for seed in np.unique(mutual["seed"])])  # of a human
        half = 1.96 * means.std(ddof=1) / np.sqrt(len(means))
        same = 100 * np.isclose(paired, 0).mean()
        told(name, table, f", minus mutual {means.mean():+.1f} +- {half:.1f} (95 %, over humans), the same in {same:.1f} %")


def cost(table):
    return table["accumulated_objective_cost_m"] + table["accumulated_subjective_cost"]


def told(name, table, more):
    arrived = (table["outcome"] == "arrived").sum()
    print(f"  {name:9} arrived {arrived} of {len(table)}, J + J^ {cost(table).mean():.1f}{more}")


if __name__ == "__main__":
    main()
