"""The notebooks run, and say what the library says."""

from __future__ import annotations

import pathlib
import re

import pytest

import cocarry

EXAMPLES = pathlib.Path(__file__).parents[1] / "examples"
pytestmark = pytest.mark.skipif(not EXAMPLES.is_dir(), reason="the examples are not next to the tests")


def executed(name, folder):
    """The outputs of a notebook that is executed in this folder."""
    nbclient, nbformat = pytest.importorskip("nbclient"), pytest.importorskip("nbformat")
    notebook = nbformat.read(EXAMPLES / name, as_version=4)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert all(not cell.outputs and cell.execution_count is None for cell in cells), "stored outputs get old: clear them"
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(folder)}}).execute()
    return [output for cell in cells for output in cell.outputs]


def count(outputs, kind):
    return sum(kind in output.get("data", {}) for output in outputs)


def pages(outputs):
    return [output["data"]["text/html"] for output in outputs if "text/html" in output.get("data", {})]


def text(outputs):
    return "".join(output.get("text", "") for output in outputs)


def test_the_notebook_goes_through_the_paper(tmp_path):
    outputs = executed("paper.ipynb", tmp_path)
    assert count(outputs, "image/svg+xml") == 1  # the world's map
    assert count(outputs, "image/png") == 2
    (player,) = pages(outputs)
    assert player.startswith("<iframe srcdoc=") and "<canvas" in player
    shown = text(outputs)
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


def test_the_notebook_of_a_study_leads_from_a_room_to_a_figure(tmp_path):
    outputs = executed("study.ipynb", tmp_path)
    shown = text(outputs)
    assert count(outputs, "image/svg+xml") == 2  # the map, the differences
    assert count(outputs, "image/png") == 1
    player, rows, compared = pages(outputs)
    assert player.startswith("<iframe srcdoc=")
    heads = re.findall(r"<th[^>]*>([^<]*)</th>", rows)
    assert heads[:5] == ["method", "eta", "seed", "alpha", "gamma"] and "accumulated_objective_cost_m" in heads
    assert "1200 episodes" in rows
    assert re.findall(r"<th[^>]*>([^<]*)</th>", compared)[:2] == ["eta", "quantity"]
    # both options are somebody's favourite, or there would be nothing to study
    shares = [float(share) for share in re.findall(r"P_o = (\S+)", shown)]
    assert len(shares) == 2 and min(shares) > 0.1
    found = cocarry.compare(tmp_path / "two-doors.csv", quantities="accumulated_objective_cost_m")
    assert set(found["pairs"]) == {200} and set(found["arrived_both"]) == {200}
    assert len(re.findall(r"^eta .*n = 200$", shown, re.MULTILINE)) == 4
