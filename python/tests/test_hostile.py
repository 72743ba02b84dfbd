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


TRIED = textwrap.dedent("""
    import os, random, resource, sys, zlib
    import cocarry

    if hasattr(resource, "RLIMIT_AS"):
        resource.setrlimit(resource.RLIMIT_AS, (6 << 30, 6 << 30))
    seen = {"read": 0, "refused": 0}

    def tried(read, errors=cocarry.Error):
        try:
            read()
            seen["read"] += 1
        except errors as error:
            # of the package: some of Python's have no words
            if isinstance(error, cocarry.Error):
                assert 0 < len(str(error)) < 20_000, str(error)[:500]
            seen["refused"] += 1

    def file(name, text):
        with open(name, "wb") as out:
            out.write(text if isinstance(text, bytes) else text.encode())
        return name

    os.chdir(sys.argv[1])
    HEAD = '<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">'
    DAE = HEAD + (
        '<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="pa" count="12">0 0 0 1 0 0 0 1 0 0 0 1</float_array>'
        '<technique_common><accessor source="#pa" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>'
        '<param name="Z" type="float"/></accessor></technique_common></source><vertices id="v"><input semantic="POSITION" source="#p"/></vertices>'
        '<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2 0 2 3 0 3 1 1 3 2</p></triangles></mesh></geometry>'
        '</library_geometries><library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node></visual_scene>'
        '</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>'
    )
    rng = random.Random(38)

    def mutant(seed):
        text = bytearray(seed)
        for _ in range(rng.randint(1, 4)):
            at = rng.randrange(len(text))
            act = rng.randrange(4)
            if act == 0:
                text[at] = rng.randrange(256)
            elif act == 1:
                del text[at : at + rng.randint(1, 60)]
            elif act == 2:
                text[at:at] = text[at : at + rng.randint(1, 60)] * rng.randint(1, 3)
            else:
                text[at:at] = rng.choice([b"4294967295", b"-1", b"nan", b"1e308", b"<a>", b'"', b"[" * 200, b"&#48;"])
        return bytes(text)
""")

MESHES = """
    URDF = '<robot name="r"><link name="base_link"><collision><geometry><mesh filename="m.dae"/></geometry></collision></link></robot>'
    TOML = 'name = "r"\\nurdf = "r.urdf"\\nbase_link = "base_link"\\ngrasp_frame = "base_link"\\nleft_wheel = "a"\\nright_wheel = "b"\\nbase_width_m = 0.5\\ngrasp_height_m = 0.7\\n[[posture]]\\nname = "p"\\n[posture.angles_deg]\\n'
    file("r.urdf", URDF), file("r.toml", TOML)
    deep = "<node>" * 20_000 + "</node>" * 20_000
    for dae in [
        DAE.replace("<p>0 1 2 ", "<p>0 1 4294967295 "),
        DAE.replace('stride="3"', 'stride="0"'),
        DAE.replace('stride="3"', 'stride="4294967295"'),
        DAE.replace('count="12"', 'count="4294967295"'),
        DAE.replace('<triangles count="4"', '<triangles count="1431655765"'),
        DAE.replace("<triangles", "<polylist").replace("</triangles", "</polylist").replace("<p>", "<vcount>4294967295</vcount><p>"),
        DAE.replace('<node id="n">', deep + '<node id="n">'),
        *(mutant(DAE.encode()) for _ in range(150)),
    ]:
        file("m.dae", dae)
        tried(lambda: cocarry.Robot("r.toml"))
    for depth in [100, 100_000]:
        file("r.urdf", '<robot name="r">' + "<a>" * depth + "</a>" * depth + "</robot>")
        tried(lambda: cocarry.Robot("r.toml"))
    # a xacro runs code, and is refused where nobody asked for it
    for urdf in [URDF.replace("<link", "<xacro:arm/><link", 1), URDF.replace('<robot ', '<robot xmlns:xacro="http://wiki.ros.org/xacro" ')]:
        file("r.urdf", urdf)
        tried(lambda: cocarry.Robot("r.toml"))
        file("r.urdf.xacro", urdf)
        tried(lambda: cocarry.Robot("r.urdf.xacro"))
    for _ in range(100):
        file("r.urdf", mutant(URDF.encode())), file("r.toml", mutant(TOML.encode()))
        tried(lambda: cocarry.Robot("r.toml"))
"""

WORLDS = """
    plain = cocarry.World("environment-4").text.encode()
    SVG = b"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 6 4' width='600' height='400'><rect x='2' y='1' width='.5' height='.5'/></svg>"
    YAML = b"image: grid.pgm\\nresolution: 0.1\\norigin: [0.0, 0.0, 0.0]\\noccupied_thresh: 0.65\\nfree_thresh: 0.196\\nnegate: 0\\n"
    file("grid.pgm", b"P5\\n60 40\\n255\\n" + b"\\xfe" * 2400)
    for text in [plain, b"a = " + b"[" * 200_000, b"a." * 200_000 + b"a = 1", b"[" + b"a." * 200_000 + b"a]", b"\\xff", b"", *(mutant(plain) for _ in range(150))]:
        tried(lambda: cocarry.World.parse(text.decode(errors="replace")).options())
    scenario = cocarry.Scenario("environment-4", plant="point", alpha=0.7, gamma=0.8).text.encode()
    for text in [scenario, *(mutant(scenario) for _ in range(100))]:
        tried(lambda: cocarry.Scenario.parse(text.decode(errors="replace")))
    ends = dict(start=(0.8, 0.8), target=(5.0, 3.0))
    for name, seed in [("m.svg", SVG), ("m.yaml", YAML), ("grid.pgm", b"P2 60 40 255 " + b"254 " * 2400)]:
        for text in [seed, b"<g>" * 100_000, b"[" * 60_000, *(mutant(seed) for _ in range(60))]:
            file(name, text)
            tried(lambda: cocarry.World.from_map("m.yaml" if name == "grid.pgm" else name, **ends))
"""

RECORDINGS = """
    scenario = cocarry.Scenario("environment-4", plant="point", alpha=0.7, gamma=0.8)
    with cocarry.Episode(scenario).record("m.mcap") as episode:
        episode.run(5)
        snapshot = episode.snapshot()
    recording = open("m.mcap", "rb").read()
    zeros = b"\\x89MCAP0\\r\\n" + b"\\x06" + (2**40).to_bytes(8, "little") + b"\\0" * 100
    for bytes_ in [b"", recording[:8], zeros, recording[: len(recording) // 2], recording, *(mutant(recording) for _ in range(150))]:
        file("m.mcap", bytes_)

        def used():
            read = cocarry.read("m.mcap")
            for topic in list(read.topics)[:3]:
                try:
                    read.table(topic)
                except cocarry.Error:
                    pass
            read.to_html(), read.replay()

        tried(used)
    # a right checksum, so that what is changed is looked at
    for _ in range(150):
        body = mutant(snapshot[:-4])
        tried(lambda: cocarry.Episode.resume(body + zlib.crc32(body).to_bytes(4, "little")).run(3))
    for rows in [b"PAR1", b"PAR1" + b"\\0" * 100 + (2**31 - 1).to_bytes(4, "little") + b"PAR1", b"x," * 1_000_000]:
        file("rows.parquet", rows)
        file("s.toml", "worlds = 'environment-1'\\nplants = 'point'\\nseeds = 1\\nmax_steps = 2\\n")
        tried(lambda: cocarry.sweep("s.toml", out="rows.parquet"))
"""


PICKLES = """
    import pickle
    scenario = cocarry.Scenario("environment-4", plant="point", alpha=0.7, gamma=0.8)
    episode = cocarry.Episode(scenario)
    table = episode.ticks(5)
    for whole in [scenario, cocarry.World(), table, episode]:
        rebuild, arguments = whole.__reduce__()
        rebuild(*arguments)
        for _ in range(60):
            forged = list(arguments)
            at = rng.randrange(len(forged))
            if isinstance(forged[at], str):
                forged[at] = mutant(forged[at].encode()).decode(errors="replace")
            elif isinstance(forged[at], bytes):
                forged[at] = mutant(forged[at])
            else:
                forged[at] = rng.choice([None, -1, 2**70, "", b"", [], {}, [[]], [None] * 9, ["number"] * 9, [[1, 2]] * 9, [b"a" * 7] * 9, float("nan")])
            # what the constructor does not take is a TypeError
            tried(lambda: rebuild(*forged), (cocarry.Error, TypeError, OverflowError))
        if whole is table:
            names, kinds, cells, about = arguments
            tried(lambda: rebuild(names, kinds, [cells[0][1:], *cells[1:]], about))
            tried(lambda: rebuild(names, ["Int64"] * len(kinds), [["1e999"] * len(column) for column in cells], about))
            tried(lambda: rebuild([], [], [], about))
        # any exception, but an exception
        for _ in range(60):
            tried(lambda: pickle.loads(mutant(pickle.dumps(whole))), Exception)
"""

TABLES = """
    people = b"participant,world,option,percent\\n" + b"".join(b"p,environment-1,%d,%d\\n" % (o, 25) for o in range(1, 5))
    for text in [b"participant,world,option,percent", people, b"\\0", b"participant," * 100_000, *(mutant(people) for _ in range(20))]:
        file("a.csv", text)
        tried(lambda: cocarry.fit_risk_weight("a.csv"))
    study = b'worlds = ["environment-1"]\\nplants = "point"\\nseeds = 1\\nmax_steps = 1\\n'
    for text in [study, *(mutant(study) for _ in range(30))]:
        file("s.toml", text)
        tried(lambda: cocarry.sweep("s.toml", seeds=1))
"""

KINDS = {"meshes": MESHES, "worlds": WORLDS, "recordings": RECORDINGS, "pickles": PICKLES, "tables": TABLES}


@pytest.mark.parametrize("files", KINDS.values(), ids=KINDS)
def test_hostile_files_never_end_the_interpreter(files, tmp_path):
    script = TRIED + textwrap.dedent(files) + 'print("ended", seen)\n'
    run = subprocess.run([sys.executable, "-X", "faulthandler", "-c", script, str(tmp_path)], capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, (run.returncode, run.stderr[-2000:])
    assert run.stdout.startswith("ended") and "panicked" not in run.stderr, (run.stdout, run.stderr[-2000:])
