"""Shows a recording in Rerun (0.41).

Rerun reads the frames of an MCAP file but not its scenes: these are handed to it shape by shape.

    pip install rerun-sdk==0.41.0 mcap mcap-protobuf-support
    python to_rerun.py run.mcap           # opens the viewer
    python to_rerun.py run.mcap run.rrd   # writes a file, for: rerun run.rrd
"""

import json
import sys

import rerun as rr
import rerun.blueprint as rrb
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

recording, *output = sys.argv[1:]

SCENES = ["/scene/world", "/scene/team", "/scene/options", "/scene/path"]
SCALARS = {
    "/coordination": ["stubbornness", "stubbornness_threshold"],
    "/interaction": ["grip_force_n", "hand_force_n"],
}
LEVELS = {2: "INFO", 3: "WARN", 4: "ERROR"}


def place(pose):
    p, q = pose.position, pose.orientation
    return [p.x, p.y, p.z], rr.Quaternion(xyzw=[q.x, q.y, q.z, q.w])


def rgba(color):
    return [round(255 * c) for c in (color.r, color.g, color.b, color.a)]


def turned(q):
    """The pose of a file whose vertical axis is z, from that of one whose is y: a quarter turn about x more."""
    half = 2**-0.5
    return [half * (q.x + q.w), half * (q.y + q.z), half * (q.z - q.y), half * (q.w - q.x)]


def shapes(entity):
    for cube in entity.cubes:
        center, turn = place(cube.pose)
        size = [cube.size.x, cube.size.y, cube.size.z]
        yield [rr.Boxes3D(sizes=[size], centers=[center], quaternions=[turn], colors=[rgba(cube.color)], fill_mode="solid")]
    for cylinder in entity.cylinders:
        center, turn = place(cylinder.pose)
        size = cylinder.size
        # Rerun has no cones
        radius = size.x / 2 * (cylinder.bottom_scale + cylinder.top_scale) / 2
        yield [rr.Cylinders3D(
            lengths=[size.z], radii=[radius], centers=[center], quaternions=[turn], colors=[rgba(cylinder.color)], fill_mode="solid",
        )]
    for sphere in entity.spheres:
        center, turn = place(sphere.pose)
        half = [sphere.size.x / 2, sphere.size.y / 2, sphere.size.z / 2]
        yield [rr.Ellipsoids3D(half_sizes=[half], centers=[center], quaternions=[turn], colors=[rgba(sphere.color)], fill_mode="solid")]
    for triangles in entity.triangles:
        points = [[p.x, p.y, p.z] for p in triangles.points]
        faces = [[i, i + 1, i + 2] for i in range(0, len(points), 3)]
        yield [rr.Mesh3D(vertex_positions=points, triangle_indices=faces, albedo_factor=rgba(triangles.color))]
    for line in entity.lines:
        points = [[p.x, p.y, p.z] for p in line.points]
        yield [rr.LineStrips3D([points], radii=[line.thickness / 2], colors=[rgba(line.color)])]
    for words in entity.texts:
        center, _ = place(words.pose)
        yield [rr.Points3D([center], labels=[words.text.replace("\n", ", ")], radii=[0.03], colors=[rgba(words.color)])]
    for model in entity.models:
        (center, turn), scale = place(model.pose), [model.scale.x, model.scale.y, model.scale.z]
        if model.media_type != "model/vnd.collada+xml":
            turn = rr.Quaternion(xyzw=turned(model.pose.orientation))
            scale = [scale[0], scale[2], scale[1]]
        color = rgba(model.color) if model.override_color else None
        yield [
            rr.Asset3D(contents=model.data, media_type=model.media_type, albedo_factor=color),
            rr.InstancePoses3D(translations=[center], quaternions=[turn], scales=[scale]),
        ]


def draw(topic, message):
    for entity in message.entities:
        for i, shape in enumerate(shapes(entity)):
            path = f"scene{topic.removeprefix('/scene')}/{entity.id}/{i}".replace(" ", "_")
            rr.log(path, rr.CoordinateFrame(entity.frame_id), *shape)


def frames(message):
    for t in message.transforms:
        p, q = t.translation, t.rotation
        rr.log(f"frames/{t.child_frame_id}", rr.Transform3D(
            translation=[p.x, p.y, p.z], quaternion=rr.Quaternion(xyzw=[q.x, q.y, q.z, q.w]),
            parent_frame=t.parent_frame_id, child_frame=t.child_frame_id,
        ))


rr.init("cocarry", spawn=not output)
if output:
    rr.save(output[0])
follow = rrb.Spatial3DView(
    name="Scene", origin="/", contents=["scene/**", "frames/**"], background=[244, 244, 246],
    eye_controls=rrb.EyeControls3D(position=[-7.0, -7.0, 8.0], look_target=[4.0, -1.0, 0.0]),
    spatial_information=rrb.SpatialInformation(target_frame="world"),
)
plots = [
    rrb.TimeSeriesView(name="Stubbornness phi", origin="/coordination"),
    rrb.TimeSeriesView(name="Probability P_o that a human prefers an option", origin="/options"),
    rrb.TimeSeriesView(name="Forces on the object, N", origin="/interaction"),
    rrb.TextLogView(name="What happened", origin="/log"),
]
rr.send_blueprint(rrb.Blueprint(
    rrb.Horizontal(follow, rrb.Vertical(*plots), column_shares=[3, 2]),
    rrb.TimePanel(timeline="time", state="collapsed"), rrb.SelectionPanel(state="hidden"), rrb.BlueprintPanel(state="hidden"),
))
colors = {}
with open(recording, "rb") as file:
    reader = make_reader(file, decoder_factories=[DecoderFactory()])
    for schema, channel, message, *_ in reader.iter_messages(topics=[*SCENES, *SCALARS, "/tf", "/options", "/log"]):
        rr.set_time("time", duration=message.log_time / 1e9)
        if channel.message_encoding == "json":
            values = json.loads(message.data)
            for key in SCALARS.get(channel.topic, []):
                rr.log(f"{channel.topic}/{key}", rr.Scalars(values[key]))
            for option in values.get("options", []):
                name, path = option["name"], f"/options/{option['name']}".replace(" ", "_")
                if name in colors:
                    rr.log(path, rr.SeriesLines(colors=[colors.pop(name)], names=[f"option {name}"]), static=True)
                if "probability" in option:
                    rr.log(path, rr.Scalars(option["probability"]))
            continue
        decode = DecoderFactory().decoder_for(channel.message_encoding, schema)
        decoded = decode(message.data)
        if channel.topic == "/tf":
            frames(decoded)
        elif channel.topic == "/log":
            rr.log("/log", rr.TextLog(decoded.message, level=LEVELS.get(decoded.level, "INFO")))
        else:
            if channel.topic == "/scene/options" and not colors:
                # curves have the colours of the lines
                colors = {e.id.removeprefix("option/"): rgba(e.lines[0].color)[:3] for e in decoded.entities}
            draw(channel.topic, decoded)
if output:
    # ends the file
    rr.disconnect()
