"""The notebook runs, and says what the library says."""

from __future__ import annotations

import pathlib
import re

import pytest

import cocarry

NOTEBOOK = pathlib.Path(__file__).parents[1] / "examples" / "paper.ipynb"
pytestmark = pytest.mark.skipif(not NOTEBOOK.is_file(), reason="the examples are not next to the tests")


def test_the_notebook_goes_through_the_paper(tmp_path):
    nbclient, nbformat = pytest.importorskip("nbclient"), pytest.importorskip("nbformat")
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert all(not cell.outputs and cell.execution_count is None for cell in cells), "stored outputs get old: clear them"
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = [output for cell in cells for output in cell.outputs]
    assert sum("image/svg+xml" in output.get("data", {}) for output in outputs) == 1  # the world's map
    assert sum("image/png" in output.get("data", {}) for output in outputs) == 2
    shown = "".join(output.get("text", "") for output in outputs)
    figures = {row["option"]: row for row in cocarry.reproduce("h1")["rows"] if row["environment"] == 4}
    found = dict(re.findall(r"option (\S+): .* P_o = (\S+)", shown))
    assert {option: round(row["ours_percent"] / 100, 2) for option, row in figures.items()} == pytest.approx(
        {option: float(share) for option, share in found.items()}, abs=0.02
    )
    # Table II: thinking of the human pays where the paper says so; 40 x 40 humans there, 8 x 8 here
    expected = {(row["environment"], row["eta"]): row["ours_mean"] for row in cocarry.reproduce("h2")["rows"]}
    rows = re.findall(r"^environment-(\d) +(\d+) +(\d+) +(\d+) +(\d+)$", shown, re.MULTILINE)
    assert len(rows) == 4
    for environment, *costs in rows:
        means = [expected[int(environment), eta] for eta in (None, 5, 10.5, 15)]
        assert [float(cost) for cost in costs] == pytest.approx(means, rel=0.02)
    # Table III: with pose optimisation it costs less, in 12 of 16 cells at least
    control = {
        (int(environment), method): [float(cost) for cost in costs.split()]
        for environment, method, costs in re.findall(r"^environment (\d), (\S+) +([\d ]+)$", shown, re.MULTILINE)
    }
    pairs = [pair for i in range(1, 5) for pair in zip(control[i, "without-po"], control[i, "with-po"])]
    assert len(pairs) == 16 and sum(with_po < without for without, with_po in pairs) >= 12
    tolerant = re.search(r"tolerant +arrived in \d+ steps, on option (\S+),", shown)
    assert tolerant and "of the paper" in shown
