"""Compares the posteriors of `cocarry infer` with draws of NUTS, which knows the paper's equations only.

From the program come the lengths of options, the openings' widths, and the intervals of eta. The likelihood of
alpha and gamma is constant between steps. So its gradient is 0, but NUTS weighs the points of a trajectory with
the density itself, and the draws have the right distribution. Adaptation would shrink the steps without end,
because trajectories that cross a step are not accepted; the step size is given.
"""

import csv
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
import scipy.stats
import zarr
from numpyro import distributions
from numpyro.infer import MCMC, NUTS

numpyro.enable_x64()

PROGRAM, *TABLES = sys.argv[1:]
DATA = pathlib.Path("docs/data")
# Sec. IV-A and V of the paper
ALPHA, GAMMA, RISK_WEIGHT, ROBOT_WIDTH = (0.55, 0.95), (0.5, 1.1), 10.0, 0.5
ETA_MEDIAN, ETA_LOG_STD = 10.5, 0.5
CHAINS, WARMUP, DRAWS, STEP_SIZE = 8, 500, 25_000, 0.3
# Participants of a given table that are compared.
MAX_PEOPLE = 6
# four deviations: one in 16 000 by chance
MOST = 4.0
# of mean and deviation of eta from a sum over pieces
MAX_DIFFERENCE = 1e-6


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


def perception(lengths, risks, shares, n, lapse):
    """The model of alpha and gamma. A row for each answer, a column for each of n options with its share."""
    alpha = numpyro.sample("alpha", distributions.Uniform(*ALPHA))
    gamma = numpyro.sample("gamma", distributions.Uniform(*GAMMA))
    perceived = lengths**alpha + RISK_WEIGHT * jnp.exp(-((-jnp.log(risks)) ** gamma))  # eq. (2)
    preferred = jnp.argmin(perceived, axis=1)  # eq. (3)
    is_preferred = jnp.arange(lengths.shape[1]) == preferred[:, None]
    # an answer is one choice, distributed as the participant says
    numpyro.factor("answers", (shares * jnp.log(jnp.where(is_preferred, 1 - lapse + lapse / n, lapse / n))).sum())


def tolerance(low, high, lapse):
    """The model of eta: a row for each task, whose eta is from `low` to `high`."""
    prior = distributions.LogNormal(jnp.log(ETA_MEDIAN), ETA_LOG_STD)
    eta = numpyro.sample("eta", prior)
    share = jnp.where(jnp.isinf(high), 1.0, prior.cdf(jnp.where(jnp.isinf(high), 1.0, high))) - prior.cdf(low)
    inside = (low <= eta) & (eta < high)
    numpyro.factor("tasks", jnp.log((1 - lapse) * inside + lapse * share).sum())


def pieces(low, high, lapse):
    """Mean and deviation of eta: between the ends of tasks the density is the prior's, times a constant."""
    ends = numpy.unique([0.0, *low, *high, numpy.inf])

    def part(power, end):
        """The integral of eta^power times the prior's density, up to `end`."""
        shifted = (numpy.log(numpy.maximum(end, 1e-300) / ETA_MEDIAN) - power * ETA_LOG_STD**2) / ETA_LOG_STD
        return ETA_MEDIAN**power * numpy.exp((power * ETA_LOG_STD) ** 2 / 2) * scipy.stats.norm.cdf(shifted)

    inside = (low <= ends[:-1, None]) & (ends[1:, None] <= high)
    likelihood = numpy.prod((1 - lapse) * inside + lapse * (part(0, high) - part(0, low)), axis=1)
    sums = [(likelihood * (part(power, ends[1:]) - part(power, ends[:-1]))).sum() for power in range(3)]
    mean = sums[1] / sums[0]
    return mean, numpy.sqrt(sums[2] / sums[0] - mean**2)


def drawn(model, seed, step, *arguments):
    kernel = NUTS(model, step_size=step, adapt_step_size=False, adapt_mass_matrix=False)
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


def table(path):
    """The rows of a table, by their columns; comments begin with #."""
    return list(csv.DictReader(line for line in path.read_text().splitlines() if line and not line.startswith("#")))


def padded(rows, value):
    """Rows as a matrix, shorter ones filled up."""
    width = max(map(len, rows))
    return numpy.array([[*row, *[value] * (width - len(row))] for row in rows])


def check_perception(path, people, lapse):
    answers = {}
    for row in table(path):
        worlds = answers.setdefault(row["participant"], {})
        worlds.setdefault(row["world"], {})[row["option"]] = float(row["percent"]) / 100
    said = cocarry("infer", path, "--no-population", "--lapse-rate", lapse)
    for person in said["people"]:
        who = person["participant"]
        if who not in people:
            continue
        tables = {world: option_table(world) for world in answers[who]}
        shares = [[answers[who][world].get(name, 0.0) for name in names] for world, (_, _, names) in tables.items()]
        # where a world has fewer options, nobody takes one of a thousand kilometres
        lengths = padded([found[0] for found in tables.values()], 1e6)
        risks = padded([found[1] for found in tables.values()], 0.5)
        counts = numpy.array([[len(names)] for _, _, names in tables.values()])
        draws = drawn(perception, 1, STEP_SIZE, lengths, risks, padded(shares, 0.0), counts, lapse)
        alpha, gamma = draws["alpha"], draws["gamma"]
        moments(who, "alpha", person["alpha"], alpha)
        moments(who, "gamma", person["gamma"], gamma)
        covariance = person["correlation"] * person["alpha"]["std"] * person["gamma"]["std"]
        both = (alpha - person["alpha"]["mean"]) * (gamma - person["gamma"]["mean"])
        compare(who, "covariance", covariance, both)
        low, high = person["gamma"]["interval"]
        compare(who, "P(gamma in 95 %)", 0.95, ((low <= gamma) & (gamma <= high)).astype(float))


def check_tolerance(path, people, lapse):
    with tempfile.TemporaryDirectory() as folder:
        draws = pathlib.Path(folder) / "people.zarr.zip"
        said = cocarry("infer", path, "--lapse-rate", lapse, "--arviz", draws)
        observed = zarr.open(zarr.ZipStore(str(draws), mode="r"), mode="r")["observed_data"]
        low, high = observed["eta_low"][:], observed["eta_high"][:]
    # tasks are in the order of the file, by participant
    names = [row["participant"] for row in table(path)]
    for person in said["people"]:
        who = person["participant"]
        if who in people:
            own = numpy.array([name == who for name in names])
            mean, std = person["eta"]["mean"], person["eta"]["std"]
            for what, ours, exact in zip(("mean", "std"), (mean, std), pieces(low[own], high[own], lapse)):
                if abs(ours / exact - 1) > MAX_DIFFERENCE:
                    worst.append(f"{who}: the {what} of eta is {ours}; piece by piece it is {exact}")
            # of the logarithm, about a deviation; chains do not leave for pieces that are far away and improbable
            eta = drawn(tolerance, 2, std / mean, low[own], high[own], lapse)["eta"]
            compare(who, "mean of eta", mean, eta)
            least, most = person["eta"]["interval"]
            compare(who, "P(eta in 95 %)", 0.95, ((least <= eta) & (eta <= most)).astype(float))


print(f"{'who':8} {'what':18} {'ours':>11} {'NUTS':>11} {'MCSE':>10} {'z':>6} {'ESS':>8} {'R-hat':>7}")
if TABLES:
    answers, switches = map(pathlib.Path, TABLES)
    first = list(dict.fromkeys(row["participant"] for row in table(answers)))[:MAX_PEOPLE]
    check_perception(answers, first, 0.1)
    check_tolerance(switches, first, 0.3)
else:
    check_perception(DATA / "simulated-answers.csv", ["anna", "clara", "grete", "ida"], 0.1)
    check_tolerance(DATA / "simulated-switches.csv", ["clara"], 0.3)
if worst:
    sys.exit("\n".join(worst))
print(f"numpyro {numpyro.__version__}: {len(rows)} figures, {CHAINS} chains of {DRAWS} draws for each person; "
      f"the largest |z| is {max(abs(score) for *_, score in rows):.2f}")
