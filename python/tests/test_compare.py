"""Custom policies and humans against the built-in ones: sweeps with names, paired comparisons, pictures, a registry."""

from __future__ import annotations

import importlib.metadata
import math
import pickle
import subprocess
import sys
import textwrap

import numpy as np
import pytest

import cocarry

STUDY = {"worlds": ["environment-1", "environment-4"], "plants": "point", "eta": [5, 10.5], "seeds": 12}


def mine(view):
    """Keeps its option until the human is half stubborn, then takes the one that humans are expected to like."""
    if view.mode == "human-led":
        return None
    if view.stubbornness < 0.5 and view.executed is not None:
        return view.executed
    cost = view.objective_cost_m if view.stubbornness < 0.5 else view.expected_subjective_cost
    return int(cost.argmin())


class Waits(cocarry.Policy):
    """Follows for some steps, then leads."""

    version = "1.2"

    def __init__(self, steps=3):
        self.steps = steps

    def decide(self, view):
        return None if view.step < self.steps or view.stance == "take-over" else int(view.objective_cost_m.argmin())


def decisive(view):
    return 0


@pytest.fixture(scope="module")
def both():
    return cocarry.sweep(STUDY, policy=[mine, "mutual"])


def test_custom_policies_and_methods_run_with_the_same_humans(both):
    assert len(both) == 2 * 2 * 2 * 12
    assert list(both["method"][:2]) == ["mine", "mutual"]
    own = both["method"] == "mine"
    assert all(len(code) == 16 for code in both["policy_code"][own]) and set(both["policy_code"][~own]) == {None}
    for key in ("seed", "world", "eta", "alpha", "gamma"):
        np.testing.assert_array_equal(both[key][own], both[key][~own])
    # alone, each has the same figures
    alone = cocarry.sweep(STUDY, policy=mine)
    np.testing.assert_array_equal(alone["accumulated_objective_cost_m"], both["accumulated_objective_cost_m"][own])
    built_in = cocarry.sweep({**STUDY, "methods": "mutual"})
    assert cocarry.sweep(STUDY, policy="mutual") == built_in
    # a study's own methods give way
    assert cocarry.sweep({**STUDY, "methods": ["mutual", "robot-led"]}, policy=mine) == alone


def test_names_versions_and_mappings():
    table = cocarry.sweep({**STUDY, "seeds": 1}, policy={"patient": Waits(9), "hasty": Waits(1)}, human={"first": decisive})
    assert set(table["method"]) == {"patient", "hasty"} and set(table["human_model"]) == {"first"}
    codes = {name: code for name, code in zip(table["method"], table["policy_code"])}
    assert codes["patient"] != codes["hasty"] and all(code.startswith("1.2 ") for code in codes.values())
    mixed = cocarry.sweep({**STUDY, "seeds": 1}, policy={"mine": mine, "mutual": "mutual"}, human={"boltzmann(2)": "boltzmann(2)"})
    assert mixed == cocarry.sweep({**STUDY, "seeds": 1}, policy=[mine, "mutual"], human="boltzmann(2)")
    humans = cocarry.sweep({**STUDY, "seeds": 2}, human=[decisive, "boltzmann(2)"])
    assert set(humans["human_model"]) == {"decisive", "boltzmann(2)"} and len(humans) == 2 * 2 * 2 * 2
    for wrong, said in [
        ([mine, mine], "two are called `mine`"),
        ({"mutual": mine}, "as a built-in one"),
        (["mutal"], "unknown method `mutal`"),
        ({"": mine}, "1 to 100 characters"),
        ([], "an empty list"),
        ({"a": "mutual"}, "policy = a mapping: 'a' is 'mutual'; it must be a custom one, .* {'mutual': 'mutual'}"),
        ({}, "an empty mapping"),
        ({5: mine}, "a name in policy = 5"),
        (7, "policy = 7"),
    ]:
        with pytest.raises(cocarry.Error, match=said):
            cocarry.sweep(STUDY, policy=wrong)
    with pytest.raises(cocarry.Error, match="unknown human model `boltzman`"):
        cocarry.sweep(STUDY, human="boltzman(2)")


def paired(table, quantity, **inputs):
    """The differences mine - mutual of the seeds with these inputs, and the row of numbers by hand."""
    is_one = np.all([table[key] == value for key, value in inputs.items()], axis=0)
    first, second = (table[quantity][is_one & (table["method"] == method)] for method in ("mine", "mutual"))
    return first - second


def test_a_comparison_is_that_of_its_definition(both):
    found = cocarry.compare(both)
    assert len(found) == 2 * 2
    assert set(found["first"]) == {"mine"} and set(found["second"]) == {"mutual"} and set(found["pairs"]) == {12}
    p_values = found["p_value"]
    for i in range(len(found)):
        d = paired(both, "accumulated_objective_cost_m", world=found["world"][i], eta=found["eta"][i])
        assert found["difference"][i] == pytest.approx(d.mean(), abs=1e-9)
        assert found["share_lower"][i] == np.mean(d < 0)
        if d.std() > 1e-9 * abs(both["accumulated_objective_cost_m"]).max():
            half = 2.200985160 * d.std(ddof=1) / math.sqrt(12)
            assert found["difference_high"][i] - d.mean() == pytest.approx(half, rel=1e-6)
            assert found["effect_size"][i] == pytest.approx(d.mean() / d.std(ddof=1))
        else:
            assert all(math.isnan(found[key][i]) for key in ("difference_low", "effect_size", "p_value", "p_holm"))
    tested = sorted(p for p in p_values if not math.isnan(p))
    assert tested and found["p_holm"][np.nanargmin(p_values)] == pytest.approx(min(1, len(tested) * tested[0]))


def test_tables_files_and_data_frames_give_the_same_comparison(both, tmp_path):
    polars = pytest.importorskip("polars")
    pandas = pytest.importorskip("pandas")
    expected = cocarry.compare(both)
    own, theirs = cocarry.sweep(STUDY, policy=mine), cocarry.sweep(STUDY, policy="mutual")
    cocarry.sweep(STUDY, policy=mine, out=tmp_path / "own.parquet")
    assert cocarry.compare(own, theirs) == expected == cocarry.compare(tmp_path / "own.parquet", theirs)
    assert cocarry.compare(cocarry.Table.concatenate([own, theirs])) == expected
    frame = polars.DataFrame(both)
    assert cocarry.compare(frame) == expected
    assert len(cocarry.compare(frame.filter(polars.col("world") == "environment-4"))) == 2
    # through a CSV file of pandas, whose numbers have other forms: the rows may be rounded, and that is told
    frame.write_csv(tmp_path / "polars.csv")
    pandas.read_csv(tmp_path / "polars.csv").to_csv(tmp_path / "pandas.csv", index=False)
    for name in ("polars.csv", "pandas.csv"):
        done = program("sweep", "--summary", tmp_path / name)
        assert done.returncode == 0 and "mine - mutual" in done.stdout, done.stderr
        close = cocarry.compare(tmp_path / name) if name == "polars.csv" else None
        assert close is None or close == expected
    with pytest.raises(cocarry.StudyError, match="it has no .*method"):
        cocarry.compare(frame.drop("method"))
    with pytest.raises(cocarry.StudyError, match="unknown column `metod`; did you mean `method`"):
        cocarry.compare(both, by="metod")
    with pytest.raises(cocarry.StudyError, match="no two combinations differ in method or pose alone"):
        cocarry.compare(own)
    with pytest.raises(cocarry.StudyError, match="there are no results"):
        cocarry.compare()


def test_names_that_pandas_reads_as_missing_survive_it(tmp_path):
    pandas = pytest.importorskip("pandas")
    table = cocarry.sweep({**STUDY, "seeds": 3}, out=tmp_path / "own.csv", policy={"NA": mine, "null": Waits(9), "None": Waits(2), "'NA'": Waits(3)})
    assert set(table["method"]) == {"'NA'", "'null'", "'None'", "''NA''"}
    expected = cocarry.compare(table)
    pandas.read_csv(tmp_path / "own.csv").to_csv(tmp_path / "pandas.csv", index=False)
    found = cocarry.compare(tmp_path / "pandas.csv")
    for key in ("first", "second", "pairs"):
        assert list(found[key]) == list(expected[key]), key


def test_averages_over_worlds_count_a_human_once(both):
    found = cocarry.compare(both, over=["world", "eta"], quantities="accumulated_subjective_cost")
    assert len(found) == 1 and found["pairs"][0] == 12 and found["arrived_both"][0] == 48
    d = both["accumulated_subjective_cost"][both["method"] == "mine"] - both["accumulated_subjective_cost"][both["method"] == "mutual"]
    assert found["difference"][0] == pytest.approx(d.mean())


def test_summaries_and_pictures(both, tmp_path):
    found = cocarry.summary(both)
    assert len(found) == 8 and set(found["n"]) == {12}
    i = list(found["method"]).index("mine")
    is_one = np.all([both[key] == found[key][i] for key in ("world", "method")], axis=0) & (both["eta"] == found["eta"][i])
    assert found["accumulated_objective_cost_m_mean"][i] == pytest.approx(both["accumulated_objective_cost_m"][is_one].mean())
    for keywords in ({}, {"kind": "differences"}, {"kind": "map", "quantity": "final_discomfort"}):
        picture = cocarry.plot(both, **keywords)
        assert picture._repr_svg_().startswith("<svg") and "mutual" in picture.svg
    saved = picture.save(tmp_path / "a.svg")
    assert saved.read_text() == picture.svg
    with pytest.raises(cocarry.StudyError, match="exists already"):
        picture.save(saved)
    with pytest.raises(cocarry.StudyError, match="a.gif: expected one of the extensions .svg, .pdf, .png"):
        picture.save(tmp_path / "a.gif")
    with pytest.raises(cocarry.StudyError, match="a.png: a picture that was not made by plot"):
        cocarry.Picture("<svg/>").save(tmp_path / "a.png")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.svg"]
    with pytest.raises(cocarry.StudyError, match="kind = 'bars'|kind = \"bars\""):
        cocarry.plot(both, kind="bars")


@pytest.mark.parametrize("width", [None, "3.5in", "1200px"])
def test_pictures_are_those_of_the_program(width, both, tmp_path):
    rows, study = tmp_path / "rows.csv", {**STUDY, "methods": ["mutual", "without-model"]}
    table = cocarry.sweep(study, out=rows)
    for kind in ("means", "differences", "map"):
        picture = pickle.loads(pickle.dumps(cocarry.plot(table, kind=kind, width=width)))
        for extension in ("svg", "pdf", "PNG"):
            file, theirs = tmp_path / f"{kind}.{extension}", tmp_path / f"{kind}-program.{extension}"
            assert picture.save(file) == file
            with pytest.raises(cocarry.StudyError, match="exists already"):
                picture.save(file)
            picture.save(file, overwrite=True)
            done = program("plot", rows, "-o", theirs, "--kind", kind, *([] if width is None else ["--width", width]))
            assert done.returncode == 0, done.stderr
            assert file.read_bytes() == theirs.read_bytes()
    assert (tmp_path / "means.pdf").read_bytes().startswith(b"%PDF") and (tmp_path / "means.PNG").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("processes", [None, 2])
def test_a_finished_file_of_the_same_study_is_read(processes, tmp_path, both):
    out, more = tmp_path / "both.csv", {} if processes is None else {"processes": processes}
    assert cocarry.sweep(STUDY, policy=[mine, "mutual"], out=out, **more) == both
    before = out.stat().st_mtime_ns, out.read_bytes()
    assert cocarry.sweep(STUDY, policy=[mine, "mutual"], out=out, **more) == both
    assert cocarry.sweep(STUDY, policy=[mine, "mutual"], out=out, table=False, **more) is None
    assert (out.stat().st_mtime_ns, out.read_bytes()) == before
    assert cocarry.sweep(STUDY, policy=[mine, "mutual"], out=out, overwrite=True, **more) == both
    assert out.stat().st_mtime_ns != before[0] and out.read_bytes() == before[1]
    # another study, other code, a part of the rows
    for keywords in ({"policy": ["mutual"]}, {"policy": [Waits(), "mutual"]}, {"policy": [mine, "mutual"], "seeds": 5}):
        with pytest.raises(cocarry.StudyError, match="both.csv: exists already; choose another name, or give overwrite=True"):
            cocarry.sweep(STUDY, out=out, **keywords, **more)
    out.write_bytes(b"".join(before[1].splitlines(keepends=True)[:-1]))
    with pytest.raises(cocarry.StudyError, match="exists already"):
        cocarry.sweep(STUDY, policy=[mine, "mutual"], out=out, **more)


def test_a_finished_shard_is_read(tmp_path):
    first = cocarry.sweep(STUDY, shard=(1, 2), out=tmp_path / "1.csv")
    assert cocarry.sweep(STUDY, shard=(1, 2), out=tmp_path / "1.csv") == first
    with pytest.raises(cocarry.StudyError, match="exists already"):
        cocarry.sweep(STUDY, shard=(2, 2), out=tmp_path / "1.csv")
    with pytest.raises(cocarry.StudyError, match="exists already"):
        cocarry.sweep(STUDY, shard=(1, 2), out=tmp_path / "1.csv", ticks=tmp_path / "ticks")


def test_a_file_of_custom_partners_resumes_where_the_code_is_equal(tmp_path, both):
    out = tmp_path / "both.csv"
    assert cocarry.sweep(STUDY, policy=[mine, "mutual"], out=out) == both
    whole = out.read_bytes()
    # as a sweep that was stopped
    partial = tmp_path / "both.csv.partial"
    out.unlink()
    lines = whole.splitlines(keepends=True)
    partial.write_bytes(b"".join(lines[:30]) + lines[30][:50])
    calls = []

    def other(view):
        calls.append(view.step)
        return mine(view)

    other.__name__ = "mine"
    with pytest.raises(cocarry.StudyError, match="the code of a custom partner.*; overwrite=True starts again"):
        cocarry.sweep(STUDY, policy=[other, "mutual"], out=out)
    assert not calls and partial.exists()
    assert cocarry.sweep(STUDY, policy=[mine, "mutual"], out=out) == both
    assert out.read_bytes() == whole
    # in processes, the same bytes
    cocarry.sweep(STUDY, policy=[mine, "mutual"], out=tmp_path / "processes.csv", processes=2)
    assert (tmp_path / "processes.csv").read_bytes() == whole
    ticks = tmp_path / "ticks"
    cocarry.sweep({**STUDY, "seeds": 1}, policy=mine, out=tmp_path / "one.csv", ticks=ticks)
    assert len(list(ticks.glob("*.parquet"))) == 1


def test_an_exception_leaves_the_rows_before_it(tmp_path):
    def fails(view):
        if view.step > 3 and view.executed == 1:
            raise RuntimeError("on purpose")
        return int(view.objective_cost_m.argmin())

    out = tmp_path / "a.csv"
    study = {**STUDY, "worlds": ["environment-4", "environment-1"], "seeds": 3}
    try:
        cocarry.sweep(study, policy=["mutual", fails], out=out, threads=1)
    except RuntimeError as error:
        assert "on purpose" in str(error) and not out.exists()
        rows = (tmp_path / "a.csv.partial").read_text().splitlines()[1:]
        assert all("not-begun" not in row for row in rows)


BODY = """
def decide(view):
    return {constant} if view.step < LIMIT else helper(view)

def helper(view):
    return {helper}

LIMIT = {limit}

class Policy:
    def __init__(self, gain=1):
        self.gain, self.seen = gain, {{"b", "a", "c"}}
    def decide(self, view):
        return decide(view) * self.gain
"""


def module(tmp_path, name="a_policy_module", constant="0", helper="1", limit="5"):
    (tmp_path / f"{name}.py").write_text(textwrap.dedent(BODY.format(constant=constant, helper=helper, limit=limit)))


def digest(tmp_path, expression):
    code = f"import sys; sys.path.insert(0, {str(tmp_path)!r}); import a_policy_module as m; from cocarry._identity import code_of; print(code_of({expression}))"
    return subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout


def test_a_digest_covers_code_data_and_state_and_is_the_same_in_every_process(tmp_path):
    module(tmp_path)
    first = {expression: digest(tmp_path, expression) for expression in ("m.decide", "m.Policy()", "m.Policy(2)", "m.Policy")}
    assert len(set(first.values())) == 4
    assert all(digest(tmp_path, expression) == found for expression, found in first.items())
    for change in ({"constant": "2"}, {"helper": "2"}, {"limit": "6"}):
        module(tmp_path, **change)
        assert all(digest(tmp_path, expression) != found for expression, found in first.items()), change
    # not comments and line numbers
    module(tmp_path)
    path = tmp_path / "a_policy_module.py"
    path.write_text("# a comment\n\n" + path.read_text())
    assert digest(tmp_path, "m.decide") == first["m.decide"]


def program(*arguments, cwd=None, path=None):
    environment = {**__import__("os").environ, "PYTHONWARNINGS": "error::ResourceWarning"}
    if path is not None:
        environment["PYTHONPATH"] = str(path)
    command = [sys.executable, "-m", "cocarry", *map(str, arguments)]
    return subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True, check=False)


@pytest.fixture
def package(tmp_path):
    """A package of somebody else's that registers policies, as pip installs it."""
    site = tmp_path / "site"
    about = site / "my_policy-2.0.dist-info"
    about.mkdir(parents=True)
    (site / "my_policy.py").write_text(
        "def lead(view):\n    return None if view.stance == 'take-over' else int(view.objective_cost_m.argmin())\n\n"
        "def fails(view):\n    raise ValueError('on purpose')\n"
    )
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: my-policy\nVersion: 2.0\n")
    (about / "entry_points.txt").write_text("[cocarry.policies]\nmy-policy = my_policy:lead\nbad = my_policy:fails\nlost = my_policy:gone\n")
    return site


def test_a_package_registers_a_policy_for_program_and_python(package, tmp_path, monkeypatch):
    done = program("run", "--plant", "point", "--method", "my-policy", "--json", "--record", "a.mcap", cwd=tmp_path, path=package)
    assert done.returncode == 0 and '"method": "my-policy"' in done.stdout, done.stderr
    assert cocarry.read(tmp_path / "a.mcap").replay()["verdict"] == "identical"
    said = program("run", "--help", path=package).stdout
    assert "my-policy" in said and "of the package my-policy 2.0" in said
    (tmp_path / "s.toml").write_text('worlds = "environment-4"\nplants = "point"\nseeds = 3\n')
    done = program("sweep", "s.toml", "--method", "my-policy", "--method", "mutual", "-o", "s.csv", cwd=tmp_path, path=package)
    assert done.returncode == 0, done.stderr
    table = cocarry.summary(tmp_path / "s.csv")
    assert list(table["method"]) == ["my-policy", "mutual"]
    for name, said in [("bad", "on purpose"), ("lost", "cannot be loaded"), ("my-polic", "my-policy")]:
        done = program("run", "--plant", "point", "--method", name, cwd=tmp_path, path=package)
        assert done.returncode == 2 and said in done.stderr and "Traceback" not in done.stderr, done.stderr
    done = program("sweep", "s.toml", "--method", "bad", "-o", "bad.csv", cwd=tmp_path, path=package)
    assert done.returncode == 2 and "on purpose" in done.stderr and not (tmp_path / "bad.csv").exists(), done.stderr
    monkeypatch.syspath_prepend(str(package))
    importlib.invalidate_caches()
    rows = cocarry.sweep(tmp_path / "s.toml", policy=["my-policy", "mutual"])
    assert set(rows["method"]) == {"my-policy", "mutual"} and rows["policy_code"][0].startswith("2.0 ")
    assert rows == cocarry.sweep(tmp_path / "s.toml", policy=["my-policy", "mutual"], out=tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_bytes() == (tmp_path / "s.csv").read_bytes()
    episode = cocarry.Episode(cocarry.Scenario("environment-4", plant="point"), policy="my-policy")
    assert episode.run()["outcome"] == "arrived"
    with pytest.raises(cocarry.DecisionError, match="policy = 'mutual'.*Scenario"):
        cocarry.Episode(cocarry.Scenario("environment-4", plant="point"), policy="mutual")


def test_a_policy_is_scored_by_the_benchmark(tmp_path):
    folder = tmp_path / "bench-1"
    subprocess.run([sys.executable, "-m", "cocarry", "bench", folder], check=True, capture_output=True)
    cocarry.sweep(folder / "small.toml", policy=[mine, "mutual"], out=tmp_path / "two.csv")
    card = cocarry.bench(folder, tmp_path / "two.csv")
    assert set(card["policy"]) == {"mine", "mutual"} and list(card["set"]) == ["small", "small"]
    of = dict(zip(card["policy"], card["score"]))
    assert list(card["score"]) == sorted(card["score"], reverse=True) and 90 < of["mutual"] <= 100
    assert next(code for policy, code in zip(card["policy"], card["policy_code"]) if policy == "mine")
    worlds = cocarry.bench(folder, tmp_path / "two.csv", worlds=True)
    assert len(worlds) == 12
    shares = [share for policy, share in zip(worlds["policy"], worlds["share_percent"]) if policy == "mutual"]
    assert of["mutual"] == pytest.approx(np.mean(shares))
    one = cocarry.sweep(folder / "small.toml", seeds=1)
    with pytest.raises(cocarry.StudyError, match="none of cocarry bench 1"):
        cocarry.bench(folder, one)
    with pytest.raises(cocarry.StudyError, match="worlds = 'yes'"):
        cocarry.bench(folder, one, worlds="yes")


def test_the_digest_of_a_class_is_the_same_after_its_episodes(tmp_path):
    # copies of its objects leave a cache in the class
    class Leads(cocarry.Policy):
        def decide(self, view):
            return 0

    study = {"worlds": ["environment-1"], "plants": "point", "seeds": 2}
    first = cocarry.sweep(study, policy=Leads)
    assert list(cocarry.sweep(study, policy=Leads)["policy_code"]) == list(first["policy_code"])
