"""Results and ticks of sweeps as Parquet files: read by pyarrow, polars, pandas and duckdb."""

from __future__ import annotations

import csv
import os
import pathlib
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import cocarry

STUDY = """# two plants
worlds = ["environment-1", "environment-4"]
plants = ["point", "kinematic"]
methods = ["mutual", "without-model"]
max_steps = 40
seeds = 3
"""


def bits(value):
    """A number as its bits."""
    return None if value is None else np.float64(value).view(np.int64)


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sweep")
    for name in ("rows.csv", "rows.parquet"):
        cocarry.sweep(STUDY, out=folder / name)
    return folder


def test_out_returns_the_table_of_a_sweep_and_its_file_has_the_bytes_of_the_program(files, tmp_path):
    table = cocarry.sweep(STUDY)
    again = cocarry.sweep(STUDY, out=tmp_path / "rows.parquet", threads=1)
    assert again == table
    (tmp_path / "study.toml").write_text(STUDY)
    program = [sys.executable, "-m", "cocarry", "sweep", "study.toml", "--output"]
    subprocess.run([*program, "program.parquet"], cwd=tmp_path, check=True, capture_output=True)
    whole = (files / "rows.parquet").read_bytes()
    assert (tmp_path / "rows.parquet").read_bytes() == whole == (tmp_path / "program.parquet").read_bytes()
    with pytest.raises(cocarry.StudyError, match="rows.parquet: exists already"):
        cocarry.sweep(STUDY, out=files / "rows.parquet")


def test_every_reader_finds_the_values_of_the_csv_file_to_the_bit(files):
    import duckdb
    import pandas
    import polars
    import pyarrow
    import pyarrow.parquet

    with open(files / "rows.csv", newline="") as file:
        cells = list(csv.DictReader(file))
    path = str(files / "rows.parquet")
    read = pyarrow.parquet.read_table(path)
    tables = {
        "pyarrow": read.to_pydict(),
        "polars": polars.read_parquet(path).to_dict(as_series=False),
        "duckdb": duckdb.sql(f"select * from '{path}'").to_arrow_table().to_pydict(),
        "pandas": pandas.read_parquet(path, dtype_backend="pyarrow").to_dict(orient="list"),
    }
    numbers = 0
    for field in read.schema:
        for reader, table in tables.items():
            values = [None if pandas.isna(value) else value for value in table[field.name]]
            texts = [row[field.name] for row in cells]
            assert len(values) == len(texts) == 24
            if pyarrow.types.is_floating(field.type):
                expected = [bits(float(text)) if text else None for text in texts]
                assert [bits(value) for value in values] == expected, (reader, field.name)
                numbers += sum(value is not None for value in values)
            elif pyarrow.types.is_integer(field.type):
                assert values == [int(text) if text else None for text in texts], (reader, field.name)
            elif pyarrow.types.is_boolean(field.type):
                assert values == [text == "true" if text else None for text in texts], (reader, field.name)
            else:
                assert values == [text or None for text in texts], (reader, field.name)
    assert numbers > 1000
    assert polars.scan_parquet(path).select("walked_m").collect().height == 24


def test_a_file_says_units_meanings_and_its_study(files):
    import pyarrow.parquet

    schema = pyarrow.parquet.read_schema(files / "rows.parquet")
    told = cocarry.quantities("episode")
    for name, (unit, description) in told.items():
        metadata = schema.field(name).metadata
        assert (metadata.get(b"unit", b"").decode(), metadata[b"description"].decode()) == (unit, description)
    origin = pyarrow.parquet.read_metadata(files / "rows.parquet").metadata
    assert origin[b"cocarry.study"].decode() == STUDY
    assert len(origin[b"cocarry.study_digest"]) == 16 and len(origin[b"cocarry.arithmetic"]) == 8


def test_ticks_of_a_sweep_are_those_of_its_episodes(tmp_path):
    import duckdb
    import polars
    import pyarrow.dataset

    rows = cocarry.sweep(STUDY, out=tmp_path / "rows.parquet", ticks=tmp_path / "ticks")
    assert rows == cocarry.sweep(STUDY)
    ticks = polars.scan_parquet(tmp_path / "ticks").collect()
    assert ticks.height == rows["steps"].sum()
    episode = cocarry.Episode(cocarry.Scenario("environment-4", plant="kinematic", seed=2, max_steps=40, method="mutual"))
    expected = polars.DataFrame(episode.ticks())
    chosen = (polars.col("world") == "environment-4") & (polars.col("plant") == "kinematic")
    found = ticks.filter(chosen & (polars.col("seed") == 2) & (polars.col("method") == "mutual"))
    assert found.height == expected.height == 40
    for column in expected.columns:
        name, _, item = column.partition("[")
        if not item:
            assert found[column].equals(expected[column], null_equal=True), column
            continue
        for rows_of in ("options", "joints"):
            items = found.select(polars.col(rows_of)).explode(rows_of).unnest(rows_of)
            if name in items.columns and item[:-1] in items["name"]:
                values = items.filter(polars.col("name") == item[:-1])[name]
                assert values.rename(column).equals(expected[column], null_equal=True), column
                break
        else:
            raise AssertionError(column)
    path = tmp_path / "ticks"
    assert pyarrow.dataset.dataset(path).count_rows() == ticks.height
    per_world = duckdb.sql(f"select world, count(*) from '{path}/*.parquet' group by world order by world").fetchall()
    assert per_world == ticks.group_by("world").len().sort("world").rows()


def test_ctrl_c_stops_a_sweep_with_files_which_resumes(tmp_path):
    study = 'worlds = "environment-1"\nplants = "rapier"\nseeds = 40\nmax_steps = 60\n'
    code = f"import cocarry; cocarry.sweep({study!r}, out='rows.parquet', ticks='ticks')"
    process = subprocess.Popen([sys.executable, "-c", code], cwd=tmp_path, stderr=subprocess.PIPE, text=True)
    partial = tmp_path / "rows.parquet.partial"
    while process.poll() is None and not (partial.exists() and partial.read_bytes().count(b"\n") > 2):
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    assert "KeyboardInterrupt" in process.communicate(timeout=60)[1]
    assert partial.exists() and not (tmp_path / "ticks").exists()
    done = []
    table = cocarry.sweep(study, out=tmp_path / "rows.parquet", progress=lambda n, count: done.append((n, count)))
    assert table == cocarry.sweep(study) and done[0][0] > 2 and done[-1] == (40, 40)


def test_what_files_cannot_have_is_refused(tmp_path):
    with pytest.raises(cocarry.StudyError, match="needs out"):
        cocarry.sweep(STUDY, ticks=tmp_path / "ticks")
    with pytest.raises(cocarry.StudyError, match="without shard"):
        cocarry.sweep(STUDY, out=tmp_path / "rows.parquet", processes=2, shard=(1, 2))
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "mine.txt").write_text("mine")
    with pytest.raises(cocarry.StudyError, match="holds mine.txt"):
        cocarry.sweep(STUDY, out=tmp_path / "rows.parquet", ticks=tmp_path / "taken", overwrite=True)
    assert os.listdir(tmp_path) == ["taken"]
    assert pathlib.Path(tmp_path / "taken" / "mine.txt").read_text() == "mine"


def test_a_sweep_without_its_table_writes_the_same_file(files, tmp_path):
    assert cocarry.sweep(STUDY, out=tmp_path / "rows.parquet", table=False) is None
    assert (tmp_path / "rows.parquet").read_bytes() == (files / "rows.parquet").read_bytes()
    for wrong in [{}, {"processes": 2}]:
        with pytest.raises(cocarry.StudyError, match="table = False: needs out"):
            cocarry.sweep(STUDY, table=False, **wrong)
