"""Compares the posteriors of `cocarry infer` with draws of NUTS, which knows the paper's equations only.

From the program come the lengths of options, the openings' widths, and the intervals of eta. The likelihood of
alpha and gamma is constant between steps. So its gradient is 0, but NUTS weighs the points of a trajectory with
the density itself, and the draws have the right distribution. Adaptation would shrink the steps without end,
because trajectories that cross a step are not accepted; the step size is given.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

import arviz
import jax
import jax.numpy as jnp
import numpy
import numpyro
import zarr
from numpyro import distributions
from numpyro.infer import MCMC, NUTS

numpyro.enable_x64()

PROGRAM = sys.argv[1]
DATA = pathlib.Path("docs/data")
# Sec. IV-A and V of the paper
ALPHA, GAMMA, RISK_WEIGHT, ROBOT_WIDTH = (0.55, 0.95), (0.5, 1.1), 10.0, 0.5
ETA_MEDIAN, ETA_LOG_STD = 10.5, 0.5
CHAINS, WARMUP, DRAWS, STEP_SIZE = 8, 500, 25_000, 0.3
# four deviations: one in 16 000 by chance
MOST = 4.0


def cocarry(*arguments):
    command = [PROGRAM, *map(str, arguments), "--json"]
    return json.loads(subprocess.run(command, check=True, capture_output=True).stdout)


def option_table(world):
    """D_o (m) and S_o of a world's options, S_o from the widths of openings."""
    said = cocarry("world", world)
    width = {opening["name"]: opening["width_m"] for opening in said["openings"]}
    lengths = [option["length_m"] for option in said["options"]]
    # S_xi = d_r / w_xi, S_o = 1 - prod (1 - S_xi)
    risks = [1 - numpy.prod([1 - ROBOT_WIDTH / width[xi] for xi in option["openings"]]) for option in said["options"]]
    return numpy.array(lengths), numpy.array(risks), [option["name"] for option in said["options"]]


def perception(lengths, risks, answers, lapse):
    """The model of alpha and gamma. A row for each answer, a column for each option."""
    alpha = numpyro.sample("alpha", distributions.Uniform(*ALPHA))
    gamma = numpyro.sample("gamma", distributions.Uniform(*GAMMA))
    perceived = lengths**alpha + RISK_WEIGHT * jnp.exp(-((-jnp.log(risks)) ** gamma))  # eq. (2)
    preferred = jnp.argmin(perceived, axis=1)  # eq. (3)
    n = lengths.shape[1]
    right = preferred == answers
    numpyro.factor("answers", jnp.log(jnp.where(right, 1 - lapse + lapse / n, lapse / n)).sum())


def tolerance(low, high, lapse):
    """The model of eta: a row for each task, whose eta is from `low` to `high`."""
    prior = distributions.LogNormal(jnp.log(ETA_MEDIAN), ETA_LOG_STD)
    eta = numpyro.sample("eta", prior)
    share = jnp.where(jnp.isinf(high), 1.0, prior.cdf(jnp.where(jnp.isinf(high), 1.0, high))) - prior.cdf(low)
    inside = (low <= eta) & (eta < high)
    numpyro.factor("tasks", jnp.log((1 - lapse) * inside + lapse * share).sum())


def drawn(model, seed, *arguments):
    kernel = NUTS(model, step_size=STEP_SIZE, adapt_step_size=False, adapt_mass_matrix=False)
    mcmc = MCMC(kernel, num_warmup=WARMUP, num_samples=DRAWS, num_chains=CHAINS, chain_method="vectorized",
                progress_bar=False)
    mcmc.run(jax.random.PRNGKey(seed), *arguments)
    return {name: numpy.asarray(values) for name, values in mcmc.get_samples(group_by_chain=True).items()}


rows, worst = [], []


def compare(who, what, ours, values):
    """The mean of `values` (chain, draw) next to ours."""
    error = float(arviz.mcse(values, method="mean"))
    r_hat, size = float(arviz.rhat(values)), float(arviz.ess(values, method="mean"))
    score = (values.mean() - ours) / error
    rows.append((who, what, score))
    print(f"{who:8} {what:18} {ours:11.6f} {values.mean():11.6f} {error:10.6f} {score:6.2f} {size:8.0f} {r_hat:7.4f}", flush=True)
    if abs(score) > MOST:
        worst.append(f"{who}: {what} has z = {score:.2f}")
    if r_hat > 1.01 or size < 2000:
        worst.append(f"{who}: {what} did not mix: R-hat {r_hat:.4f}, {size:.0f} effective draws")


def moments(who, name, ours, values):
    compare(who, f"mean of {name}", ours["mean"], values)
    # about our mean: where the means agree, the error is of second order
    compare(who, f"variance of {name}", ours["std"] ** 2, (values - ours["mean"]) ** 2)


def check_perception(people, lapse):
    answers = {}
    for line in (DATA / "simulated-answers.csv").read_text().splitlines():
        cells = line.split(",")
        if cells[-1] == "100":
            answers.setdefault(cells[0], []).append((cells[1], cells[2]))
    said = cocarry("infer", DATA / "simulated-answers.csv", "--no-population", "--lapse-rate", lapse)
    for person in said["people"]:
        who = person["participant"]
        if who not in people:
            continue
        tables = [option_table(world) for world, _ in answers[who]]
        chosen = [names.index(option) for (_, option), (_, _, names) in zip(answers[who], tables, strict=True)]
        lengths, risks = (numpy.array([table[k] for table in tables]) for k in (0, 1))
        draws = drawn(perception, 1, lengths, risks, numpy.array(chosen), lapse)
        alpha, gamma = draws["alpha"], draws["gamma"]
        moments(who, "alpha", person["alpha"], alpha)
        moments(who, "gamma", person["gamma"], gamma)
        covariance = person["correlation"] * person["alpha"]["std"] * person["gamma"]["std"]
        both = (alpha - person["alpha"]["mean"]) * (gamma - person["gamma"]["mean"])
        compare(who, "covariance", covariance, both)
        low, high = person["gamma"]["interval"]
        compare(who, "P(gamma in 95 %)", 0.95, ((low <= gamma) & (gamma <= high)).astype(float))


def check_tolerance(people, lapse):
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "people.zarr.zip"
        said = cocarry("infer", DATA / "simulated-switches.csv", "--lapse-rate", lapse, "--arviz", path)
        observed = zarr.open(zarr.ZipStore(str(path), mode="r"), mode="r")["observed_data"]
        low, high = observed["eta_low"][:], observed["eta_high"][:]
    # tasks are in the order of the file, by participant
    names = [line.split(",")[0] for line in (DATA / "simulated-switches.csv").read_text().splitlines()]
    names = [name for name in names if name and not name.startswith("#") and name != "participant"]
    for person in said["people"]:
        who = person["participant"]
        if who in people:
            own = numpy.array([name == who for name in names])
            eta = drawn(tolerance, 2, low[own], high[own], lapse)["eta"]
            moments(who, "eta", person["eta"], eta)


print(f"{'who':8} {'what':18} {'ours':>11} {'NUTS':>11} {'MCSE':>10} {'z':>6} {'ESS':>8} {'R-hat':>7}")
check_perception(["anna", "clara", "grete", "ida"], 0.1)
check_tolerance(["clara"], 0.3)
if worst:
    sys.exit("\n".join(worst))
print(f"numpyro {numpyro.__version__}: {len(rows)} figures, {CHAINS} chains of {DRAWS} draws for each person; "
      f"the largest |z| is {max(abs(score) for *_, score in rows):.2f}")
