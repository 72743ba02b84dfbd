"""Draws a recording with Rerun, which reads the frames of an MCAP file but not its scenes: these are handed to it shape by shape.

    pip install rerun-sdk mcap mcap-protobuf-support
    python rerun_picture.py run.mcap run.rrd [seconds]
    rerun --headless --port 0 --bind 127.0.0.1 --window-size 1200x800 --screenshot-to run.png run.rrd
"""

import sys

import rerun as rr
import rerun.blueprint as rrb
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

recording, output = sys.argv[1:3]
until = float(sys.argv[3]) if len(sys.argv) > 3 else float("inf")

SCENES = ["/scene/world", "/scene/team", "/scene/options", "/scene/path"]


def place(pose):
    p, q = pose.position, pose.orientation
    return [p.x, p.y, p.z], rr.Quaternion(xyzw=[q.x, q.y, q.z, q.w])


def rgba(color):
    return [round(255 * c) for c in (color.r, color.g, color.b, color.a)]


def shapes(entity):
    for cube in entity.cubes:
        center, turn = place(cube.pose)
        size = [cube.size.x, cube.size.y, cube.size.z]
        yield rr.Boxes3D(sizes=[size], centers=[center], quaternions=[turn], colors=[rgba(cube.color)], fill_mode="solid")
    for cylinder in entity.cylinders:
        center, turn = place(cylinder.pose)
        size = cylinder.size
        yield rr.Cylinders3D(
            lengths=[size.z], radii=[size.x / 2], centers=[center], quaternions=[turn],
            colors=[rgba(cylinder.color)], fill_mode="solid",
        )
    for sphere in entity.spheres:
        center, _ = place(sphere.pose)
        half = [sphere.size.x / 2, sphere.size.y / 2, sphere.size.z / 2]
        yield rr.Ellipsoids3D(half_sizes=[half], centers=[center], colors=[rgba(sphere.color)], fill_mode="solid")
    for triangles in entity.triangles:
        points = [[p.x, p.y, p.z] for p in triangles.points]
        faces = [[i, i + 1, i + 2] for i in range(0, len(points), 3)]
        yield rr.Mesh3D(vertex_positions=points, triangle_indices=faces, albedo_factor=rgba(triangles.color))
    for line in entity.lines:
        points = [[p.x, p.y, p.z] for p in line.points]
        yield rr.LineStrips3D([points], radii=[line.thickness / 2], colors=[rgba(line.color)])


rr.init("cocarry")
entities, transforms = {}, {}
with open(recording, "rb") as file:
    reader = make_reader(file, decoder_factories=[DecoderFactory()])
    for item in reader.iter_decoded_messages(topics=[*SCENES, "/tf"]):
        if item.message.log_time > until * 1e9:
            break
        if item.channel.topic == "/tf":
            transforms.update((t.child_frame_id, t) for t in item.decoded_message.transforms)
        else:
            entities.update(((item.channel.topic, e.id), e) for e in item.decoded_message.entities)
# the eye is behind and above the object, or the world's origin where there is none
at = transforms["object"].translation if "object" in transforms else None
x, y = (at.x, at.y) if at else (0.0, 0.0)
eye = rrb.EyeControls3D(position=[x - 6.0, y - 6.0, 6.0], look_target=[x, y, 0.7])
view = rrb.Spatial3DView(
    origin="/",
    contents="geometry/**",
    background=[244, 244, 246],
    eye_controls=eye,
    spatial_information=rrb.SpatialInformation(target_frame="world"),
)
rr.save(output, default_blueprint=rrb.Blueprint(view, collapse_panels=True))
for frame, t in transforms.items():
    p, q = t.translation, t.rotation
    rr.log(
        f"frames/{frame}",
        rr.Transform3D(
            translation=[p.x, p.y, p.z], quaternion=rr.Quaternion(xyzw=[q.x, q.y, q.z, q.w]),
            parent_frame=t.parent_frame_id, child_frame=frame,
        ),
        static=True,
    )
for (topic, name), entity in entities.items():
    for i, shape in enumerate(shapes(entity)):
        path = f"geometry{topic}/{name}/{i}".replace(" ", "_")
        rr.log(path, rr.CoordinateFrame(entity.frame_id), shape, static=True)
