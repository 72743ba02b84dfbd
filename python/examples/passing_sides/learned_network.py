"""The network of the learned planner: a variational recurrent neural network (VRNN). Inference alone, in NumPy.

After E. Ng, Z. Liu and M. Kennedy III, "It Takes Two: Learning to Plan for Human-Robot Cooperative Carrying", ICRA 2023
(arXiv:2209.12890). Sizes, names of parameters and what their code decides are those of the authors' public code
(eleyng/cooperative_planner, MIT). This is an implementation of its own, in double precision.

At every step, with h the output of the upper GRU layer, [a, b] a concatenation, and e standard normal noise:

    while observed:  phi_x = emb_x(x),   mean, v = enc_mean, enc_std of enc([phi_x, h])
    after that:                          mean, v = prior_mean, prior_std of prior(h)
    z = mean + exp(v / 2) e              v is a logarithm of variances, whatever its name says
    phi_z = emb_z(z),   x' = dec([phi_z, h]);   after the observed steps, phi_x = emb_x(x')
    h <- GRU([phi_x, phi_z], h)

The published weights are not part of this package: `Vrnn.read` takes the file of a checkpoint of PyTorch Lightning.
"""

from __future__ import annotations

import argparse
import collections
import pathlib
import pickle
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from passing_inference import Floats


def parameter_shapes(features: int, hidden: int, latents: int, layers: int) -> dict[str, tuple[int, ...]]:
    """The name and shape of every parameter of a network of such sizes; a weight is (outputs, inputs)."""
    linear = {
        "emb_x.0": (hidden, features),
        "emb_x.2": (hidden, hidden),
        "emb_z.0": (hidden, latents),
        "enc.0": (hidden, 2 * hidden),
        "enc.2": (hidden, hidden),
        "enc_mean": (latents, hidden),
        "enc_std": (latents, hidden),
        "dec.0": (hidden, 2 * hidden),
        "dec.2": (features, hidden),
        "prior.0": (hidden, hidden),
        "prior.2": (hidden, hidden),
        "prior_mean": (latents, hidden),
        "prior_std": (latents, hidden),
    }
    shapes: dict[str, tuple[int, ...]] = {}
    for name, shape in linear.items():
        shapes |= {f"{name}.weight": shape, f"{name}.bias": shape[:1]}
    for layer in range(layers):
        inputs = 2 * hidden if layer == 0 else hidden
        shapes |= {f"gru.weight_ih_l{layer}": (3 * hidden, inputs), f"gru.weight_hh_l{layer}": (3 * hidden, hidden)}
        shapes |= {f"gru.bias_ih_l{layer}": (3 * hidden,), f"gru.bias_hh_l{layer}": (3 * hidden,)}
    return shapes


@dataclass(frozen=True)
class Vrnn:
    """A VRNN with its parameters.

    parameters: by name, as `parameter_shapes` has them.
    observed: how many steps of a sequence are observed; the prior has the latents of those after them.
    """

    parameters: Mapping[str, Floats]
    observed: int

    def __post_init__(self) -> None:
        found = {name: np.shape(value) for name, value in self.parameters.items()}
        hidden, features = found.get("emb_x.0.weight", (0, 0))
        latents = found.get("enc_mean.bias", (0,))[0]
        wanted = parameter_shapes(features, hidden, latents, self.layers)
        wrong = sorted(name for name in {*found, *wanted} if found.get(name) != wanted.get(name))
        if wrong or self.layers == 0:
            name = wrong[0] if wrong else "gru.weight_ih_l0"
            raise ValueError(f"the parameter {name} of a VRNN has the shape {found.get(name)}, not {wanted.get(name)}")
        if self.observed < 1:
            raise ValueError(f"observed is {self.observed}; it has to be at least 1")

    @classmethod
    def read(cls, path: str | pathlib.Path) -> Vrnn:
        """The network of a checkpoint of PyTorch Lightning, of which parameters and hyperparameters are taken.

        Nothing in the file is run. Observed are H // skip steps of its hyperparameters.
        """
        content = read_checkpoint(path)
        try:
            settings = vars(content["hyper_parameters"]["hparams"])
            parameters = {name: np.asarray(value, float) for name, value in content["state_dict"].items()}
            observed = int(settings["H"]) // int(settings["skip"])
            if settings["include_actions"]:
                raise ValueError("its network takes actions, which this one does not")
            return cls(parameters, observed)
        except (KeyError, TypeError, ValueError, ZeroDivisionError) as error:
            raise ValueError(f"{path}: no checkpoint of a VRNN: {error}") from error

    @property
    def layers(self) -> int:
        """Number of GRU layers."""
        return sum(name.startswith("gru.weight_ih_l") for name in self.parameters)

    @property
    def hidden(self) -> int:
        """Number of hidden units."""
        return len(self.parameters["emb_x.0.bias"])

    @property
    def latents(self) -> int:
        """Dimension of a latent."""
        return len(self.parameters["enc_mean.bias"])

    def sample(self, inputs: Floats, noise: Floats) -> Floats:
        """Decoded sequences (n, steps, features), of observed inputs and with the noise of the latents.

        inputs: (t, features), the same for all sequences, or (n, t, features); the first `observed` are taken.
        noise: standard normal, (n, steps, latents).
        """
        count, steps, _ = noise.shape
        inputs = np.broadcast_to(inputs, (count, *np.shape(inputs)[-2:]))
        if inputs.shape[1] < min(self.observed, steps):
            raise ValueError(f"{inputs.shape[1]} steps of inputs; {self.observed} are to be observed")
        hidden = np.zeros((self.layers, count, self.hidden))
        decoded = []
        for step in range(steps):
            upper = hidden[-1]
            if step < self.observed:
                embedded = self._embedded(inputs[:, step])
                latent = self._latent("enc", np.concatenate([embedded, upper], axis=-1), noise[:, step])
            else:
                latent = self._latent("prior", upper, noise[:, step])
            latent = _positive(self._linear("emb_z.0", latent))
            output = self._linear("dec.2", _positive(self._linear("dec.0", np.concatenate([latent, upper], axis=-1))))
            if step >= self.observed:
                embedded = self._embedded(output)
            hidden = self._recurred(np.concatenate([embedded, latent], axis=-1), hidden)
            decoded.append(output)
        return np.stack(decoded, axis=1)

    def _linear(self, name: str, value: Floats) -> Floats:
        return np.asarray(value @ self.parameters[f"{name}.weight"].T + self.parameters[f"{name}.bias"])

    def _embedded(self, features: Floats) -> Floats:
        return _positive(self._linear("emb_x.2", _positive(self._linear("emb_x.0", features))))

    def _latent(self, name: str, value: Floats, noise: Floats) -> Floats:
        """The latents (n, latents), of the encoder or the prior."""
        value = _positive(self._linear(f"{name}.2", _positive(self._linear(f"{name}.0", value))))
        return np.asarray(self._linear(f"{name}_mean", value) + np.exp(0.5 * self._linear(f"{name}_std", value)) * noise)

    def _recurred(self, value: Floats, hidden: Floats) -> Floats:
        """The states (layers, n, hidden) of the GRU after inputs (n, 2 hidden).

        Of every layer, with gates in the order reset r, update z, candidate c:
        c = tanh(W_c x + b_c + r (U_c h + d_c)), h <- (1 - z) c + z h.
        """
        states = []
        for layer, state in enumerate(hidden):
            given = value @ self.parameters[f"gru.weight_ih_l{layer}"].T + self.parameters[f"gru.bias_ih_l{layer}"]
            own = state @ self.parameters[f"gru.weight_hh_l{layer}"].T + self.parameters[f"gru.bias_hh_l{layer}"]
            (given_r, given_z, given_c), (own_r, own_z, own_c) = np.split(given, 3, axis=-1), np.split(own, 3, axis=-1)
            update = _logistic(given_z + own_z)
            value = (1.0 - update) * np.tanh(given_c + _logistic(given_r + own_r) * own_c) + update * state
            states.append(value)
        return np.stack(states)


def _positive(value: Floats) -> Floats:
    return np.asarray(np.maximum(value, 0.0))


def _logistic(value: Floats) -> Floats:
    return np.asarray(0.5 * (1.0 + np.tanh(0.5 * value)))


def read_checkpoint(path: str | pathlib.Path) -> dict[str, Any]:
    """The content of a file that PyTorch wrote, with arrays in the place of tensors, without PyTorch.

    The file is a ZIP archive of a pickle and of raw numbers. Only containers, tensors of numbers and
    `argparse.Namespace` are made of the pickle; any other name in it is refused.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            [name] = [name for name in archive.namelist() if name.endswith("/data.pkl")]
            with archive.open(name) as file:
                content = _Unpickler(file, archive, name.removesuffix("data.pkl")).load()
    except (zipfile.BadZipFile, pickle.UnpicklingError, EOFError, KeyError, ValueError) as error:
        raise ValueError(f"{path}: no file of PyTorch that can be read: {error}") from error
    if not isinstance(content, dict):
        raise ValueError(f"{path}: its content is no dictionary")
    return content


class _Unpickler(pickle.Unpickler):
    """Reads the pickle of an archive of PyTorch, without running what it names."""

    def __init__(self, file: Any, archive: zipfile.ZipFile, folder: str) -> None:
        super().__init__(file)
        self.archive, self.folder = archive, folder

    def find_class(self, module: str, name: str) -> Any:
        """What a name of the pickle stands for."""
        known: dict[str, Any] = {
            "collections.OrderedDict": collections.OrderedDict,
            "argparse.Namespace": argparse.Namespace,
            "torch._utils._rebuild_tensor_v2": _strided,
            "torch.FloatStorage": "<f4",
            "torch.DoubleStorage": "<f8",
            "torch.LongStorage": "<i8",
        }
        if f"{module}.{name}" not in known:
            raise pickle.UnpicklingError(f"it names {module}.{name}")
        return known[f"{module}.{name}"]

    def persistent_load(self, identifier: Any) -> Any:
        """The numbers of a storage: its kind, its file in the archive, the device and the count."""
        _, kind, key, _, count = identifier
        return np.frombuffer(self.archive.read(f"{self.folder}data/{key}"), kind, count)


def _strided(storage: Any, offset: int, size: tuple[int, ...], stride: tuple[int, ...], *_: Any) -> Any:
    """The array of a tensor: its part of a storage."""
    last = offset + sum((length - 1) * step for length, step in zip(size, stride))
    if min((offset, *size, *stride)) < 0 or last >= len(storage):
        raise ValueError("a tensor goes beyond its numbers")
    steps = [step * storage.itemsize for step in stride]
    return np.lib.stride_tricks.as_strided(storage[offset:], size, steps, writeable=False)
