"""Writes the URDFs of `porter` and `shuttle`, two robots of this project's own design, and their meshes.

    python3 assets/robots/make.py

Every part is a loft: a stack of rings of points with a lid at either end. Visual meshes are Wavefront OBJ with
smooth normals, collision meshes are the same lofts with fewer points, as binary STL. Inertias are those of the
lofts, filled evenly. Lengths are in metres, masses in kilograms. Needs Python 3.11 and nothing else; the same
files are written every time. The robot files (`porter.toml`, `shuttle.toml`) are written by hand.
"""

import math
import pathlib
import struct

HERE = pathlib.Path(__file__).parent
# Faces that meet at less than this are drawn as one smooth surface
CREASE = math.cos(math.radians(40))
COLOURS = {"white": "0.93 0.92 0.89", "grey": "0.42 0.44 0.47", "black": "0.13 0.13 0.14", "teal": "0.1 0.45 0.45", "amber": "0.86 0.55 0.13"}


def add(a, b):
    return tuple(x + y for x, y in zip(a, b))


def sub(a, b):
    return tuple(x - y for x, y in zip(a, b))


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    length = math.sqrt(dot(a, a))
    return tuple(x / length for x in a)


# Rings: functions of the number of points on a quarter turn


def disc(radius, at):
    """A circle about the stacking axis, at this height of the stack."""

    def ring(fineness):
        count = 4 * fineness
        turns = [2 * math.pi * i / count for i in range(count)]
        return [(radius * math.cos(turn), radius * math.sin(turn), at) for turn in turns]

    return ring


def plate(half_x, half_y, corner, at):
    """A rectangle with round corners."""

    def ring(fineness):
        steps = max(1, fineness // 2)
        points = []
        for quarter, (sx, sy) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
            for i in range(steps + 1):
                turn = math.pi / 2 * (quarter + i / steps)
                x, y = sx * (half_x - corner), sy * (half_y - corner)
                points.append((x + corner * math.cos(turn), y + corner * math.sin(turn), at))
        return points

    return ring


# Axes of a stack: the directions of a ring's x and y, and that of the stack
ALONG = {"x": ((0, 1, 0), (0, 0, 1), (1, 0, 0)), "y": ((0, 0, 1), (1, 0, 0), (0, 1, 0)), "z": ((1, 0, 0), (0, 1, 0), (0, 0, 1))}


class Solid:
    """A loft of rings along an axis from a place, in a colour."""

    def __init__(self, colour, rings, at=(0, 0, 0), along="z", fineness=4, is_solid=True, coarse=None):
        self.colour, self.rings, self.at, self.fineness = colour, rings, at, fineness
        self.axes = ALONG[along] if isinstance(along, str) else along
        # whether it collides and has mass
        self.is_solid = is_solid
        # the rings of its collision shape
        self.coarse = coarse or rings

    def loft(self, fineness, rings=None):
        """Points, and faces that are counterclockwise from outside."""
        points, faces = [], []
        x, y, z = self.axes
        rings = [ring(fineness) for ring in rings or self.rings]
        for ring in rings:
            points += [tuple(self.at[k] + p[0] * x[k] + p[1] * y[k] + p[2] * z[k] for k in range(3)) for p in ring]
        count = len(rings[0])
        faces.append([*range(count)][::-1])
        for level in range(len(rings) - 1):
            low, high = level * count, (level + 1) * count
            for i in range(count):
                j = (i + 1) % count
                faces.append([low + i, low + j, high + j, high + i])
        faces.append([(len(rings) - 1) * count + i for i in range(count)])
        return points, faces


def bar(colour, length, radius, at=(0, 0, 0), along="x", **more):
    """A round bar with bevelled ends."""
    bevel = 0.25 * radius
    rings = [disc(radius - bevel, 0), disc(radius, bevel), disc(radius, length - bevel), disc(radius - bevel, length)]
    return Solid(colour, rings, at, along, coarse=[disc(radius, 0), disc(radius, length)], **more)


def knuckle(colour, radius, half, along="y", at=(0, 0, 0)):
    """The housing of a joint: a bar across its middle."""
    axis = ALONG[along][2]
    return bar(colour, 2 * half, radius, tuple(at[k] - half * axis[k] for k in range(3)), along)


def block(colour, half_x, half_y, low, high, corner=0.02, at=(0, 0, 0), along="z", **more):
    """A plate with round corners and bevelled edges, from `low` to `high`."""
    bevel = min(0.008, 0.2 * (high - low))
    inner = (half_x - bevel, half_y - bevel, max(corner - bevel, 0.002))
    rings = [plate(*inner, low), plate(half_x, half_y, corner, low + bevel)]
    rings += [plate(half_x, half_y, corner, high - bevel), plate(*inner, high)]
    coarse = [plate(half_x, half_y, corner, low), plate(half_x, half_y, corner, high)]
    return Solid(colour, rings, at, along, coarse=coarse, **more)


def triangles(points, faces):
    for face in faces:
        for i in range(1, len(face) - 1):
            yield points[face[0]], points[face[i]], points[face[i + 1]]


def write_obj(file, solids):
    """Positions to a tenth of a millimetre, normals to a hundredth."""
    lines, positions, normals = [f"# {file.parent.name}: {file.stem}"], {}, {}
    body = []

    def index(known, prefix, values, digits):
        text = " ".join(f"{round(value, digits) + 0.0:.{digits}g}" if digits < 3 else f"{round(value, digits) + 0.0:g}" for value in values)
        if text not in known:
            known[text] = len(known) + 1
            lines.append(f"{prefix} {text}")
        return known[text]

    for solid in solids:
        points, faces = solid.loft(solid.fineness)
        own = [unit(cross(sub(points[f[1]], points[f[0]]), sub(points[f[2]], points[f[0]]))) for f in faces]
        around = {}
        for number, face in enumerate(faces):
            for point in face:
                around.setdefault(point, []).append(number)
        for number, face in enumerate(faces):
            corners = []
            for point in face:
                total = (0, 0, 0)
                for other in around[point]:
                    if dot(own[number], own[other]) > CREASE:
                        total = add(total, own[other])
                corners.append(f"{index(positions, 'v', points[point], 4)}//{index(normals, 'vn', unit(total), 2)}")
            body.append("f " + " ".join(corners))
    file.write_text("\n".join(lines + body) + "\n")


def write_stl(file, solids):
    """Binary STL."""
    facets = []
    for solid in solids:
        for a, b, c in triangles(*solid.loft(2, solid.coarse)):
            across = cross(sub(b, a), sub(c, a))
            if dot(across, across) > 0:
                facets.append(struct.pack("<12fH", *unit(across), *a, *b, *c, 0))
    file.write_bytes(f"{file.parent.name} {file.stem}".encode().ljust(80) + struct.pack("<I", len(facets)) + b"".join(facets))


def inertia(solids, mass):
    """Centre of mass, and the moments xx, xy, xz, yy, yz, zz about it."""
    volume, first = 0.0, [0.0] * 3
    second = [[0.0] * 3 for _ in range(3)]
    for solid in solids:
        for corners in triangles(*solid.loft(8)):
            # a tetrahedron from the origin
            part = dot(corners[0], cross(corners[1], corners[2])) / 6
            volume += part
            total = [sum(c[i] for c in corners) for i in range(3)]
            for i in range(3):
                first[i] += part * total[i] / 4
                for j in range(3):
                    second[i][j] += part * (total[i] * total[j] + sum(c[i] * c[j] for c in corners)) / 20
    centre = [value / volume for value in first]
    density = mass / volume
    spread = [[density * second[i][j] - mass * centre[i] * centre[j] for j in range(3)] for i in range(3)]
    trace = sum(spread[i][i] for i in range(3))
    moments = [[(trace if i == j else 0.0) - spread[i][j] for j in range(3)] for i in range(3)]
    return centre, [moments[0][0], moments[0][1], moments[0][2], moments[1][1], moments[1][2], moments[2][2]]


class Robot:
    """Links and joints, as they are written into a URDF."""

    def __init__(self, name, about):
        self.name, self.folder = name, HERE / name
        self.folder.mkdir(exist_ok=True)
        for old in self.folder.iterdir():
            old.unlink()
        self.lines = ['<?xml version="1.0"?>', f"<!-- {about}", "     Written by make.py. -->", f'<robot name="{name}">']
        self.lines += [f'  <material name="{colour}"><color rgba="{rgb} 1"/></material>' for colour, rgb in COLOURS.items()]

    def link(self, name, mass, solids, collision=None, meshes=None):
        """One visual mesh for each colour and one collision mesh, or `collision` in its place. `meshes` begins
        the names of the files, if not the link's name."""
        lines = self.lines
        if not solids:
            lines.append(f'  <link name="{name}"/>')
            return
        filled = [solid for solid in solids if solid.is_solid]
        centre, moments = inertia(filled, mass)
        number = lambda value: f"{round(value, 6) + 0.0:g}"
        keys = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        lines += [
            f'  <link name="{name}">',
            f'    <inertial><origin xyz="{" ".join(map(number, centre))}"/><mass value="{mass:g}"/>',
            "      <inertia " + " ".join(f'{key}="{number(value)}"' for key, value in zip(keys, moments)) + "/></inertial>",
        ]
        base = meshes or name.removesuffix("_link")
        for colour in dict.fromkeys(solid.colour for solid in solids):
            file = self.folder / f"{base}_{colour}.obj"
            write_obj(file, [solid for solid in solids if solid.colour == colour])
            lines.append(
                f'    <visual><geometry><mesh filename="{self.name}/{file.name}"/></geometry><material name="{colour}"/></visual>'
            )
        if collision is None:
            file = self.folder / f"{base}.stl"
            write_stl(file, filled)
            collision = f'<geometry><mesh filename="{self.name}/{file.name}"/></geometry>'
        lines += [f"    <collision>{collision}</collision>", "  </link>"]

    def joint(self, name, kind, parent, child, at, axis=None, limits=None):
        inner = f'<parent link="{parent}"/><child link="{child}"/><origin xyz="{at}"/>'
        if axis:
            inner += f'<axis xyz="{axis}"/>'
        if limits:
            inner += "<limit " + " ".join(f'{key}="{value:g}"' for key, value in limits.items()) + "/>"
        self.lines.append(f'  <joint name="{name}" type="{kind}">{inner}</joint>')

    def done(self):
        (HERE / f"{self.name}.urdf").write_text("\n".join(self.lines + ["</robot>"]) + "\n")


def revolute(lower, upper, rate, effort):
    return {"lower": lower, "upper": upper, "velocity": rate, "effort": effort}


def wheel_collision(radius, width):
    return f'<origin rpy="1.5707963267948966 0 0"/><geometry><cylinder radius="{radius}" length="{width}"/></geometry>'


def gripper(robot, parent, at, reach):
    """A palm with two fingers that hold the object `reach` ahead."""
    robot.link("gripper_link", 0.9, [
        bar("grey", 0.03, 0.036, is_solid=False),
        block("grey", 0.025, 0.06, 0.028, 0.075, 0.012, along="x"),
        block("black", 0.018, 0.009, 0.07, reach + 0.025, 0.006, (0, 0.028, 0), "x", fineness=2),
        block("black", 0.018, 0.009, 0.07, reach + 0.025, 0.006, (0, -0.028, 0), "x", fineness=2),
    ])
    robot.joint("gripper_joint", "fixed", parent, "gripper_link", at)
    robot.link("grasp_link", 0, [])
    robot.joint("grasp_joint", "fixed", "gripper_link", "grasp_link", f"{reach} 0 0")


def porter():
    """A differential base, a column with a lift, and an arm with a round wrist."""
    robot = Robot("porter", "A base on two driven wheels, a lift, and an arm of six joints. The origin is on the floor, between the wheels.")
    ball = lambda x: Solid("black", [disc(r, z) for r, z in ((0.012, 0.0), (0.028, 0.008), (0.035, 0.03), (0.03, 0.056))], (x, 0, 0), fineness=3, is_solid=False)
    robot.link("base_link", 52, [
        Solid("grey", [plate(0.2, 0.15, 0.08, 0.045), plate(0.225, 0.17, 0.1, 0.07), plate(0.225, 0.17, 0.1, 0.2), plate(0.21, 0.155, 0.09, 0.208)], fineness=8),
        Solid("white", [disc(0.23, 0.212), disc(0.24, 0.22), disc(0.24, 0.262), disc(0.215, 0.28)], fineness=10),
        ball(0.17), ball(-0.17),
        bar("amber", 0.012, 0.05, (0.218, 0, 0.14), "x", is_solid=False),
    ])
    for side, y in (("left", 0.2), ("right", -0.2)):
        tyre = Solid("black", [disc(r, z) for r, z in ((0.08, -0.018), (0.094, -0.018), (0.1, -0.01), (0.1, 0.01), (0.094, 0.018), (0.08, 0.018))], along="y", fineness=8)
        hub = Solid("grey", [disc(0.03, -0.022), disc(0.078, -0.012), disc(0.078, 0.012), disc(0.03, 0.022)], along="y", is_solid=False)
        robot.link(f"{side}_wheel_link", 1.6, [tyre, hub], wheel_collision(0.1, 0.036), "wheel")
        robot.joint(f"{side}_wheel_joint", "continuous", "base_link", f"{side}_wheel_link", f"0 {y} 0.1", "0 1 0", {"velocity": 11, "effort": 14})
    robot.link("column_link", 11, [block("white", 0.05, 0.075, 0.0, 0.74, 0.025), block("grey", 0.008, 0.035, 0.04, 0.7, 0.004, (0.05, 0, 0), is_solid=False)])
    robot.joint("column_joint", "fixed", "base_link", "column_link", "-0.13 0 0.275")
    # the arm's root slides along the column's front
    robot.link("lift_link", 4, [
        block("teal", 0.07, 0.09, 0.055, 0.09, 0.02, (0, 0, 0), "x"),
        block("teal", 0.075, 0.07, -0.03, 0.0, 0.03, (0.13, 0, 0)),
    ])
    robot.joint("lift_joint", "prismatic", "column_link", "lift_link", "0 0 0.26", "0 0 1", {"lower": 0, "upper": 0.36, "velocity": 0.15, "effort": 900})
    pan = "shoulder_pan_link"
    robot.link(pan, 3.2, [bar("grey", 0.06, 0.06, (0, 0, 0), "z"), knuckle("teal", 0.058, 0.065, at=(0.03, 0, 0.095))])
    robot.joint("shoulder_pan_joint", "revolute", "lift_link", pan, "0.145 0 0", "0 0 1", revolute(-2.6, 2.6, 2.6, 90))
    robot.link("upper_arm_link", 3.4, [bar("white", 0.27, 0.047, (0.03, 0, 0)), knuckle("teal", 0.05, 0.056, at=(0.33, 0, 0))])
    robot.joint("shoulder_lift_joint", "revolute", pan, "upper_arm_link", "0.03 0 0.095", "0 1 0", revolute(-2.0, 1.6, 2.6, 150))
    robot.link("forearm_link", 2.2, [bar("white", 0.16, 0.043, (0.02, 0, 0))])
    robot.joint("elbow_joint", "revolute", "upper_arm_link", "forearm_link", "0.33 0 0", "0 1 0", revolute(-2.5, 2.5, 2.6, 90))
    robot.link("wrist_roll_link", 1.5, [bar("grey", 0.09, 0.04), knuckle("teal", 0.041, 0.046, at=(0.12, 0, 0))])
    robot.joint("forearm_roll_joint", "revolute", "forearm_link", "wrist_roll_link", "0.18 0 0", "1 0 0", revolute(-3.0, 3.0, 3.2, 35))
    robot.link("wrist_link", 1.2, [bar("white", 0.08, 0.036, (0.02, 0, 0))])
    robot.joint("wrist_flex_joint", "revolute", "wrist_roll_link", "wrist_link", "0.12 0 0", "0 1 0", revolute(-2.1, 2.1, 3.2, 30))
    robot.link("tool_link", 0.4, [bar("teal", 0.025, 0.036)])
    robot.joint("tool_roll_joint", "revolute", "wrist_link", "tool_link", "0.1 0 0", "1 0 0", revolute(-3.0, 3.0, 2.8, 12))
    gripper(robot, "tool_link", "0.025 0 0", 0.13)
    robot.done()


def mecanum(turn):
    """A wheel of 65 mm whose lowest roller lies along (1, turn, 0): a rim with eight rollers."""
    half = math.sqrt(0.5)
    solids = [
        Solid("grey", [disc(r, z) for r, z in ((0.018, -0.0225), (0.042, -0.0205), (0.042, 0.0205), (0.018, 0.0225))], along="y", fineness=5),
    ]
    for i in range(8):
        angle = 2 * math.pi * i / 8
        cos, sin = math.cos(angle), math.sin(angle)
        around = lambda p: (p[0] * cos + p[2] * sin, p[1], -p[0] * sin + p[2] * cos)
        along = around((half, turn * half, 0))
        radial = around((0, 0, -1))
        rings = [disc(r, z) for r, z in ((0.008, -0.026), (0.0135, 0), (0.008, 0.026))]
        solids.append(Solid("black", rings, tuple(0.0515 * k for k in radial), (radial, cross(along, radial), along), fineness=2))
    return solids


def shuttle():
    """Four mecanum wheels, a pedestal, and an arm whose links lie side by side."""
    robot = Robot("shuttle", "A base on four mecanum wheels and an arm of six joints, three of them parallel. The origin is on the floor, in the middle of the wheels.")
    robot.link("base_link", 58, [
        Solid("grey", [plate(0.2, 0.105, 0.03, 0.035), plate(0.21, 0.115, 0.04, 0.05), plate(0.21, 0.115, 0.04, 0.134)], fineness=4),
        Solid("white", [plate(0.18, 0.18, 0.08, 0.134), plate(0.195, 0.195, 0.09, 0.15), plate(0.195, 0.195, 0.09, 0.25), plate(0.165, 0.165, 0.075, 0.29)], fineness=8),
        Solid("amber", [plate(0.196, 0.196, 0.09, 0.19), plate(0.196, 0.196, 0.09, 0.205)], fineness=8, is_solid=False),
    ])
    for end, x in (("front", 0.12), ("rear", -0.12)):
        for side, y in (("left", 0.145), ("right", -0.145)):
            hand = -1 if (end == "front") == (side == "left") else 1
            name = f"{end}_{side}_mecanum"
            # two kinds of wheel, which mirror each other
            kind = "mecanum_a" if hand < 0 else "mecanum_b"
            robot.link(f"{name}_link", 1.4, mecanum(hand), wheel_collision(0.065, 0.045), kind)
            robot.joint(f"{name}_joint", "continuous", "base_link", f"{name}_link", f"{x} {y} 0.065", "0 1 0", {"velocity": 18, "effort": 9})
    robot.link("pedestal_link", 9, [
        Solid("grey", [plate(0.09, 0.09, 0.03, 0), plate(0.065, 0.065, 0.03, 0.06), plate(0.055, 0.055, 0.03, 0.2), plate(0.065, 0.065, 0.04, 0.25)], fineness=6),
    ])
    robot.joint("pedestal_joint", "fixed", "base_link", "pedestal_link", "-0.02 0 0.285")
    robot.link("turret_link", 3.6, [bar("white", 0.07, 0.062, along="z"), bar("teal", 0.14, 0.06, (0, -0.062, 0.11), "y")])
    robot.joint("turret_joint", "revolute", "pedestal_link", "turret_link", "0 0 0.25", "0 0 1", revolute(-3.1, 3.1, 2.0, 120))
    # next to the turret, on its left
    robot.link("boom_link", 4.8, [bar("white", 0.1, 0.058, (0, -0.02, 0), "y"), bar("white", 0.36, 0.044, (0.0, 0.035, 0)), bar("teal", 0.1, 0.05, (0.36, -0.012, 0), "y")])
    robot.joint("boom_joint", "revolute", "turret_link", "boom_link", "0 0.1 0.11", "0 1 0", revolute(-2.6, 2.0, 2.0, 150))
    # back in the middle
    robot.link("stick_link", 2.9, [bar("white", 0.095, 0.047, (0, -0.05, 0), "y"), bar("white", 0.33, 0.038, (0, -0.005, 0)), bar("teal", 0.08, 0.04, (0.33, -0.04, 0), "y")])
    robot.joint("stick_joint", "revolute", "boom_link", "stick_link", "0.36 -0.06 0", "0 1 0", revolute(-2.7, 2.7, 2.2, 100))
    robot.link("wrist_pitch_link", 1.2, [bar("grey", 0.07, 0.038, (0.0, -0.035, 0), "y"), bar("grey", 0.05, 0.034, (0.02, 0, 0))])
    robot.joint("wrist_pitch_joint", "revolute", "stick_link", "wrist_pitch_link", "0.33 -0.04 0", "0 1 0", revolute(-2.9, 2.9, 2.6, 30))
    robot.link("wrist_yaw_link", 1.0, [bar("teal", 0.08, 0.038, (0, 0, -0.04), "z"), bar("grey", 0.05, 0.033, (0.015, 0, 0))])
    robot.joint("wrist_yaw_joint", "revolute", "wrist_pitch_link", "wrist_yaw_link", "0.09 0 0", "0 0 1", revolute(-2.0, 2.0, 2.6, 30))
    robot.link("wrist_roll_link", 0.4, [bar("teal", 0.025, 0.034)])
    robot.joint("wrist_roll_joint", "revolute", "wrist_yaw_link", "wrist_roll_link", "0.075 0 0", "1 0 0", revolute(-3.1, 3.1, 3.0, 12))
    gripper(robot, "wrist_roll_link", "0.025 0 0", 0.13)
    robot.done()


if __name__ == "__main__":
    porter()
    shuttle()
