"""Compares the store of `cocarry infer --arviz`, as ArviZ reads it, with `cocarry infer --json`."""

import json
import pathlib
import subprocess
import sys
import tempfile

import arviz
import numpy
import xarray
import zarr

PROGRAM = sys.argv[1]
DATA = pathlib.Path("docs/data")


def infer(*arguments):
    command = [PROGRAM, "infer", *map(str, arguments), "--json"]
    return json.loads(subprocess.run(command, check=True, capture_output=True).stdout)


def opened(path):
    if zarr.__version__.startswith("2."):
        return arviz.from_zarr(zarr.ZipStore(str(path), mode="r"))
    tree = xarray.open_datatree(zarr.storage.ZipStore(str(path), mode="r"), engine="zarr")
    return arviz.InferenceData.from_datatree(tree)


def near(found, wanted, std, what):
    """4000 draws: a mean is within 5 standard errors, a standard deviation or an end within 0.2."""
    assert abs(found - wanted) < std, f"{what}: {found}, not {wanted}"


def check(*arguments, population):
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "people.zarr.zip"
        said = infer(*arguments, "--arviz", path)
        data = opened(path)
        assert set(data.groups()) == {"posterior", "prior", "sample_stats", "observed_data"}, data.groups()
        posterior = data.posterior.load()
        assert posterior.sizes["chain"] == 4 and posterior.sizes["draw"] == 1000
        names = [person["participant"] for person in said["people"]]
        assert list(posterior.participant.values) == names
        for person in said["people"]:
            own = posterior.sel(participant=person["participant"])
            within = person["within_population"] or [person["alpha"], person["gamma"]]
            figures = [("alpha", within[0], 1e-9 if population else None), ("gamma", within[1], 1e-9 if population else None)]
            figures += [("eta", person["eta"], None)] if person["eta"] else []
            for name, figure, exact in figures:
                values, std = own[name].values.ravel(), figure["std"]
                near(values.mean(), figure["mean"], exact or 5 * std / len(values) ** 0.5, f"mean of {name}")
                low, high = numpy.quantile(values, [0.025, 0.975])
                near(low, figure["interval"][0], 0.2 * std, f"low end of {name}")
                near(high, figure["interval"][1], 0.2 * std, f"high end of {name}")
        # independent draws: all of them count, and chains agree
        summary = arviz.summary(data)
        assert (summary["r_hat"] <= 1.01).all(), summary
        assert (summary["ess_bulk"] > 3000).all(), summary["ess_bulk"].min()
        assert ("alpha_mu" in posterior) == population
        assert data.sample_stats.lp.shape == (4, 1000) and numpy.isfinite(data.sample_stats.lp.values).all()
        assert data.prior.alpha.shape == posterior.alpha.shape
        return data, said


both, said = check(DATA / "simulated-answers.csv", DATA / "simulated-switches.csv", population=True)
shares = both.observed_data.share
assert numpy.allclose(shares.sum("option"), 4.0), "four answers of each participant"
rows = [line for line in open(DATA / "simulated-answers.csv") if line.startswith("anna,environment-1,")]
for row in rows:
    _, world, option, percent = row.strip().split(",")
    assert float(shares.sel(answerer="anna", option=f"{world}: {option}")) == float(percent) / 100
low, high = both.observed_data.eta_low.values, both.observed_data.eta_high.values
assert len(low) == 20 and (low < high).all() and numpy.isinf(high).any()
check(DATA / "simulated-answers.csv", "--no-population", population=False)
check(DATA / "simulated-switches.csv", population=False)
print(f"zarr {zarr.__version__}, arviz {arviz.__version__}: 3 passed, 0 failed")
