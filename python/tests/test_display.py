"""What tables show of themselves, and the colours of pictures."""

from __future__ import annotations

import re

import numpy as np
import pytest

import cocarry

STUDY = {"worlds": ["environment-1", "environment-4"], "plants": "point", "methods": ["mutual", "without-model"], "seeds": 20}


def heads(table):
    return re.findall(r"<th[^>]*>([^<]*)</th>", table._repr_html_())


def rows(table):
    return [re.findall(r"<td>([^<]*)</td>", row) for row in re.findall(r"<tr>(<td>.*?)</tr>", table._repr_html_())]


def test_a_sweep_shows_what_varied_then_what_came_out():
    table = cocarry.sweep(STUDY)
    assert heads(table)[:8] == [
        "world", "method", "seed", "alpha", "gamma", "outcome", "accumulated_objective_cost_m", "accumulated_subjective_cost",
    ]  # fmt: skip
    assert not {"checksum", "study", "arithmetic", "plant", "eta", "pose"} & set(heads(table))
    assert len(heads(table)) < 15 < len(table.columns)
    html = table._repr_html_()
    assert "80 episodes; varied: world (2), method (2), seed (20)" in html
    assert "the same in all: plant point" in html and "20 of 80 rows" in html
    assert repr(table).startswith("<cocarry.Table, 80 rows, ") and "varied: world (2), method (2), seed (20)" in repr(table)


def test_cells_are_short_and_say_what_the_columns_say():
    table = cocarry.sweep({**STUDY, "eta": [5, 10.5]})
    place = heads(table).index("accumulated_objective_cost_m")
    shown = [float(row[place]) for row in rows(table)]
    np.testing.assert_allclose(shown, table["accumulated_objective_cost_m"][: len(shown)], rtol=1e-5)
    assert max(len(cell) for row in rows(table) for cell in row if re.fullmatch(r"[-+.\de]+", cell)) <= 12
    assert heads(table)[:3] == ["world", "method", "eta"]


@pytest.mark.parametrize(
    "table",
    [
        cocarry.sweep({**STUDY, "seeds": 1, "worlds": "environment-1", "methods": "mutual"}),
        cocarry.Episode(cocarry.Scenario("environment-4", plant="point")).ticks(0),
        cocarry.Episode(cocarry.Scenario("environment-4", plant="point")).ticks(3),
        cocarry.summary(cocarry.sweep({**STUDY, "seeds": 3})),
    ],
    ids=["one row", "no rows", "ticks", "summary"],
)
def test_every_table_shows_itself(table):
    html = table._repr_html_()
    assert html.count("<tr>") == 1 + min(len(table), 20) and repr(table).startswith(f"<cocarry.Table, {len(table)} rows")


def test_a_comparison_is_printed_with_its_figures():
    table = cocarry.sweep({**STUDY, "eta": [5, 10.5]})
    found = cocarry.compare(table)
    lines = str(found).splitlines()
    assert lines[:2] == [
        "accumulated_objective_cost_m: mutual - without-model",
        "world           eta   n  difference     95 % interval  p (Holm)",
    ]
    assert len(lines) == 2 + 4 + 2 and lines[-1] == f"4 rows; {len(found.columns)} columns, table.columns lists all"
    for i, line in enumerate(lines[2:6]):
        words = line.split()
        assert words[:3] == [found["world"][i], f"{found['eta'][i]:g}", "20"]
        figures = [float(words[at]) for at in (3, 4, 6, 7)]
        columns = ("difference", "difference_low", "difference_high", "p_holm")
        np.testing.assert_allclose(figures, [found[name][i] for name in columns], rtol=0.05)
    assert repr(found) == f"<cocarry.Table, 4 rows, {len(found.columns)} columns>"
    # where all humans make the same choices, there is no interval
    by_quantity = str(cocarry.compare(table, quantities=["final_discomfort", "accumulated_objective_cost_m"], over="world"))
    assert "final_discomfort: mutual - without-model\n" in by_quantity and "accumulated_objective_cost_m: mutual - without-model\n" in by_quantity
    assert all(line.split()[-2:] == ["-", "-"] for line in by_quantity.partition("final_discomfort")[2].splitlines()[2:4])


def test_printed_lines_have_at_most_80_characters():
    def policy(view):
        return None

    long = {"a" * 99: policy, "b\u202e" + "c" * 60: policy, "mutual": "mutual"}
    study = {**STUDY, "seeds": 3, "eta": [5, 10.5], "risk_weight_m": [10, 12]}
    rows = cocarry.sweep(study, policy=long)
    ticks = cocarry.Episode(cocarry.Scenario("environment-4", plant="point")).ticks
    few = cocarry.compare(rows, over=["world", "eta"])
    assert len(few) <= 20
    for table in [rows, cocarry.compare(rows), few, cocarry.summary(rows), ticks(0), ticks(3)]:
        lines = str(table).splitlines()
        assert max(map(len, lines)) <= 80
        assert all(line.isprintable() for line in lines)
    assert str(rows).startswith(f"<cocarry.Table, {len(rows)} rows, ") and f"5 of {len(rows)} rows" in str(rows)
    assert "environment-1" in str(rows) and len(str(rows).splitlines()) <= 11


def test_names_of_worlds_and_policies_are_text_on_the_page():
    def policy(view):
        return None

    table = cocarry.sweep({**STUDY, "seeds": 1}, policy={"<b>x</b>": policy, "a & b": policy})
    assert "&lt;b&gt;x&lt;/b&gt;" in table._repr_html_() and "a &amp; b" in table._repr_html_() and "<b>" not in table._repr_html_()


def test_the_colours_of_options_are_those_of_the_player():
    episode = cocarry.Episode(cocarry.Scenario("environment-4", plant="point"))
    episode.run(2)
    found = re.findall(r'"colour":"(#[0-9a-f]{6})"', episode.to_html())
    options = [cocarry.option_colour(i) for i in range(len(episode.scenario.options))]
    assert options == ["#0072b2", "#e69f00", "#882255", "#009e73"][: len(options)]
    assert [colour for colour in found if colour in options][: len(options)] == options
    assert len({cocarry.option_colour(i) for i in range(16)}) == 8 and cocarry.option_colour(8) == options[0]
    for wrong in (-1, 1.5, "0", None, True):
        with pytest.raises(cocarry.Error, match="index = "):
            cocarry.option_colour(wrong)
