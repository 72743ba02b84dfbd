"""Sweeps on a real Ray cluster of two raylets: whatever dies, the rows are those of one process, byte for byte."""

from __future__ import annotations

import contextlib
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time

import pytest

import cocarry
from cocarry import _cocarry, _ray

ray = pytest.importorskip("ray")
cluster_utils = pytest.importorskip("ray.cluster_utils")

STUDY = """
worlds = ["mine.toml", "environment-4"]
plants = "point"
methods = ["mutual", "without-model", "robot-led"]
eta = [5, 15]
seeds = 500
"""


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    folder = tmp_path_factory.mktemp("study")
    (folder / "study.toml").write_text(STUDY)
    # a world that only the driver's folder has
    export = [sys.executable, "-m", "cocarry", "export", "environment-2"]
    subprocess.run(export, cwd=folder, check=True, capture_output=True)
    (folder / "environment-2.toml").rename(folder / "mine.toml")
    cocarry.sweep(folder / "study.toml", out=folder / "expected.csv")
    return folder


@pytest.fixture
def cluster(monkeypatch):
    monkeypatch.setattr(_ray, "BLOCK_S", 0.15)
    monkeypatch.setenv("RAY_ENABLE_UV_RUN_RUNTIME_ENV", "0")
    cluster = cluster_utils.Cluster(initialize_head=True, head_node_args={"num_cpus": 1})
    cluster.second = cluster.add_node(num_cpus=1)
    cluster.wait_for_nodes()
    yield cluster
    ray.shutdown()
    cluster.shutdown()


def at(share: float, act):
    """A teller of progress that acts once, when this share of the episodes is done and `act` finds what it needs."""
    acted = []

    def tell(done, count):
        if not acted and done >= share * count and act() is not None:
            acted.append(True)

    tell.acted = acted
    return tell


def workers() -> list[int]:
    """The processes that run blocks."""
    found = []
    for entry in pathlib.Path("/proc").iterdir():
        try:
            if (entry / "cmdline").read_bytes().startswith(b"ray::") and b"rows" in (entry / "cmdline").read_bytes():
                found.append(int(entry.name))
        except (OSError, ValueError):
            continue
    return found


def go_on(worker: int) -> None:
    # its raylet may have been killed meanwhile, and the worker with it
    with contextlib.suppress(ProcessLookupError):
        os.kill(worker, signal.SIGCONT)


def test_a_killed_raylet_a_killed_worker_and_a_stopped_one(study, cluster):
    def kill_worker():
        # as the kernel does where memory runs out
        for worker in workers()[:1]:
            os.kill(worker, signal.SIGKILL)
            return worker

    def stop_worker():
        for worker in workers()[:1]:
            os.kill(worker, signal.SIGSTOP)
            threading.Timer(2.0, go_on, (worker,)).start()
            return worker

    def kill_raylet():
        cluster.remove_node(cluster.second, allow_graceful=False)
        return cluster

    tells = [at(0.05, kill_worker), at(0.2, stop_worker), at(0.5, kill_raylet)]
    table = cocarry.sweep(
        study / "study.toml", out=study / "ray.csv", backend="ray", address=cluster.address,
        progress=lambda done, count: [tell(done, count) for tell in tells],
    )
    assert [tell.acted for tell in tells] == [[True]] * 3
    assert (study / "ray.csv").read_bytes() == (study / "expected.csv").read_bytes()
    assert len(table) == (study / "expected.csv").read_bytes().count(b"\n") - 1


def test_workers_that_ray_kills_when_memory_runs_out(study, monkeypatch):
    monkeypatch.setattr(_ray, "BLOCK_S", 0.15)
    monkeypatch.setenv("RAY_ENABLE_UV_RUN_RUNTIME_ENV", "0")
    memory = {key: int(value.split()[0]) for key, value in
              (line.split(":") for line in pathlib.Path("/proc/meminfo").read_text().splitlines())}
    more = 2 << 20  # kB
    used = memory["MemTotal"] - memory["MemAvailable"]
    if memory["MemAvailable"] < 3 * more:
        pytest.skip("this needs 6 GB of free memory")
    # Ray kills workers while another process uses 2 GiB
    threshold = (used + 0.7 * more) / memory["MemTotal"]
    system = {"memory_usage_threshold": threshold, "memory_monitor_refresh_ms": 50}
    cluster = cluster_utils.Cluster(initialize_head=True, head_node_args={"num_cpus": 2, "_system_config": system})
    killed = []

    def fill():
        before = workers()
        if not before:
            return None
        hog = subprocess.Popen([sys.executable, "-c", f"import time; a = b'x' * ({more} << 10); time.sleep(60)"])
        begun = time.monotonic()
        while not killed and time.monotonic() - begun < 30:
            killed.extend(worker for worker in before if not pathlib.Path(f"/proc/{worker}").exists())
            time.sleep(0.05)
        hog.kill()
        hog.wait()
        return hog

    tell = at(0.2, fill)
    try:
        cocarry.sweep(study / "study.toml", out=study / "memory.csv", backend="ray", address=cluster.address, progress=tell)
    finally:
        ray.shutdown()
        cluster.shutdown()
    assert killed
    assert (study / "memory.csv").read_bytes() == (study / "expected.csv").read_bytes()


DRIVER = """
import sys, cocarry
from cocarry import _ray
_ray.BLOCK_S = 0.2
cocarry.sweep(sys.argv[1] + "/study.toml", out=sys.argv[1] + "/killed.csv", backend="ray", address=sys.argv[2])
"""


def test_a_killed_driver_goes_on_where_it_was(study, cluster):
    driver = subprocess.Popen([sys.executable, "-c", DRIVER, str(study), cluster.address])
    partial = study / "killed.csv.partial"
    begun = time.monotonic()
    while not partial.exists() or partial.stat().st_size < (study / "expected.csv").stat().st_size // 4:
        assert driver.poll() is None and time.monotonic() - begun < 120
        time.sleep(0.02)
    driver.kill()
    driver.wait()
    kept = partial.read_bytes().count(b"\n") - 1
    first = []
    table = cocarry.sweep(study / "study.toml", out=study / "killed.csv", backend="ray", address=cluster.address,
                          progress=lambda done, count: first.append(done), table=False)
    assert table is None
    assert 0 < first[0] <= kept < (study / "expected.csv").read_bytes().count(b"\n") - 1
    assert (study / "killed.csv").read_bytes() == (study / "expected.csv").read_bytes()


def test_what_cannot_be_joined_is_refused_before_work_is_sent(study, cluster, monkeypatch):
    with monkeypatch.context() as other:
        other.setattr(_cocarry, "__version__", "0.0.9")
        with pytest.raises(cocarry.StudyError, match=r"node .*: version 0\.1\.0; here it is 0\.0\.9"):
            cocarry.sweep(study / "study.toml", backend="ray", address=cluster.address)
    # of another study
    with pytest.raises(cocarry.StudyError, match="exists already"):
        cocarry.sweep(study / "study.toml", seeds=2, out=study / "expected.csv", backend="ray", address=cluster.address)
    for wrong, message in [
        ({"backend": "dask"}, 'backend = \'dask\'; it must be "ray"'),
        ({"address": "localhost:1"}, 'needs backend = "ray"'),
        ({"backend": "ray", "threads": 2}, "without shard, threads"),
    ]:
        with pytest.raises(cocarry.StudyError, match=message):
            cocarry.sweep(study / "study.toml", **wrong)


def test_another_cluster_than_the_connected_one_is_told(study, cluster):
    ray.init(address=cluster.address, log_to_driver=False)
    with pytest.raises(cocarry.StudyError, match="connected to .*ray.shutdown"):
        cocarry.sweep(study / "study.toml", backend="ray", address="127.0.0.1:9")
    table = cocarry.sweep(study / "study.toml", seeds=2, backend="ray", address=cluster.address)
    assert len(table) == 24


def test_a_cluster_that_is_not_there_is_told(study):
    with pytest.raises(cocarry.StudyError, match="no Ray cluster there"):
        cocarry.sweep(study / "study.toml", backend="ray", address="127.0.0.1:9")


def test_a_custom_policy_in_the_small_set_of_the_benchmark(cluster, tmp_path):
    class Cautious(cocarry.Policy):
        """Workers do not have this module: the class is sent along."""

        name, version = "cautious", "1"

        def decide(self, view):
            if view.mode == "human-led" or view.stubbornness > 0.5:
                return None
            return int(view.objective_cost_m.argmin())

    subprocess.run([sys.executable, "-m", "cocarry", "bench", "bench-1"], cwd=tmp_path, check=True, capture_output=True)
    study = tmp_path / "bench-1" / "small.toml"
    cocarry.sweep(study, policy=Cautious, out=tmp_path / "alone.csv")
    cocarry.sweep(study, policy=Cautious, out=tmp_path / "ray.csv", backend="ray", address=cluster.address)
    assert (tmp_path / "ray.csv").read_bytes() == (tmp_path / "alone.csv").read_bytes()
    card = cocarry.bench(tmp_path / "bench-1", tmp_path / "ray.csv")
    assert list(card["policy"]) == ["cautious"]


def test_a_policy_that_cannot_be_sent_is_refused(cluster, tmp_path):
    lock = threading.Lock()
    study = {"worlds": ["environment-1"], "plants": "point", "seeds": 1}
    with pytest.raises(cocarry.StudyError, match="cannot be sent to workers"):
        cocarry.sweep(study, policy=lambda view: lock.locked() or None, backend="ray", address=cluster.address)
