"""Forged and extreme inputs end in an exception of the package, and processors agree."""

from __future__ import annotations

import os
import random
import struct
import subprocess
import sys
import textwrap
import zlib

import pytest

import cocarry


def recorded(tmp_path) -> bytes:
    """A recording of custom partners: their decisions are in it."""
    scenario = cocarry.Scenario("environment-4", plant="point", alpha=0.747, gamma=0.765)
    policy = lambda view: view.step % 2 if view.step < 30 else None  # noqa: E731
    with cocarry.Episode(scenario, policy=policy).record(tmp_path / "own.mcap") as episode:
        episode.run(40)
    return (tmp_path / "own.mcap").read_bytes()


def with_decisions(recording: bytes, forged) -> bytes:
    """The recording with its decisions changed by `forged`, which keeps the length; the check sum is right."""
    name = recording.index(b"decisions.json")
    start = name - 4 - 16  # after the log and the creation time of the attachment
    kind = name + len(b"decisions.json")
    (length,) = struct.unpack_from("<I", recording, kind)
    data = kind + 4 + length + 8
    (size,) = struct.unpack_from("<Q", recording, data - 8)
    changed = forged(recording[data : data + size])
    assert len(changed) == size
    body = recording[start:data] + changed
    return recording[:start] + body + struct.pack("<I", zlib.crc32(body)) + recording[data + size + 4 :]


def test_forged_decisions_are_refused_or_replayed_to_a_difference(tmp_path):
    recording = recorded(tmp_path)
    file = tmp_path / "forged.mcap"
    file.write_bytes(with_decisions(recording, lambda data: data))
    assert cocarry.read(file).replay()["verdict"] == "identical"
    rng, seen = random.Random(0), {"refused": 0, "identical": 0, "different": 0}
    for _ in range(200):

        def forged(data):
            data = bytearray(data)
            for _ in range(rng.randint(1, 4)):
                data[rng.randrange(len(data))] = rng.choice(b'0123456789-e.,:"[]{}nult ')
            return bytes(data)

        file.write_bytes(with_decisions(recording, forged))
        try:
            verdict = cocarry.read(file).replay()["verdict"]
            seen["identical" if verdict == "identical" else "different"] += 1
        except cocarry.Error:
            seen["refused"] += 1
    assert seen["refused"] > 50, seen


def test_damaged_snapshots_are_refused():
    episode = cocarry.Episode(cocarry.Scenario("environment-2", plant="rapier", alpha=0.7, gamma=0.8))
    episode.run(5)
    snapshot, rng = episode.snapshot(), random.Random(1)
    for _ in range(100):
        damaged = bytearray(snapshot)
        damaged[rng.randrange(len(damaged))] ^= 1 << rng.randrange(8)
        with pytest.raises(cocarry.SnapshotError):
            cocarry.Episode.resume(bytes(damaged))
    with pytest.raises(cocarry.SnapshotError):
        cocarry.Episode.resume(snapshot[:-1])


@pytest.mark.parametrize("far", [1e3, 1e12, 1e300])
def test_a_hand_far_away_ends_the_episode_or_is_refused(far):
    def runs_off(view):
        return cocarry.HumanDecision(0, stance="take-over", hand=(far, -far))

    episode = cocarry.Episode(cocarry.Scenario("environment-4", plant="rapier", alpha=0.7, gamma=0.8), human=runs_off)
    try:
        outcome = episode.run(60)
    except cocarry.Error:
        return
    assert outcome != "arrived"


OWN_PARTNERS = textwrap.dedent("""
    import hashlib, sys
    import numpy as np
    import cocarry

    def eq6(view):
        if view.mode == "human-led" or view.stance == "take-over":
            return None
        phi = min(view.stubbornness, 1.0)
        return int(((1 - phi) * view.objective_cost_m + phi * view.expected_subjective_cost).argmin())

    for plant in ["point", "kinematic", "rapier"]:
        episode = cocarry.Episode(cocarry.Scenario("environment-4", plant=plant, alpha=0.747, gamma=0.765), policy=eq6)
        episode.run(30)
        print(hashlib.sha256(episode.recording()).hexdigest())
""")


def test_own_partners_give_the_same_bytes_on_another_processor():
    def told(**variables):
        environment = {**os.environ, **variables}
        run = subprocess.run([sys.executable, "-c", OWN_PARTNERS], env=environment, capture_output=True, text=True)
        assert run.returncode == 0, run.stderr
        return run.stdout

    here = told()
    assert len(set(here.split())) == 3
    assert told(GLIBC_TUNABLES="glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2") == here
