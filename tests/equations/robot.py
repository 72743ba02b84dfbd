"""A robot from its URDF and robot file: its grasp's pose and Jacobian, its base's motion, its inputs' limits.

A configuration q is x, y, yaw of the base, then the joints. Inputs: rim speeds left and right, or velocity
ahead and to the left and turning rate; then the rates of the joints.
"""

import xml.etree.ElementTree as xml

import numpy as np


def rotation(vector):
    """The rotation matrix of a rotation vector (Rodrigues)."""
    angle = np.linalg.norm(vector)
    x, y, z = vector / angle if angle > 0 else vector
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def difference(to, of):
    """x of eq. (7): translation and rotation vector, world axes, of the pose `to` relative to `of`."""
    r = to[:3, :3] @ of[:3, :3].T
    axis = np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]]) / 2
    sine = np.linalg.norm(axis)
    angle = np.arctan2(sine, (np.trace(r) - 1) / 2)
    return np.append(to[:3, 3] - of[:3, 3], axis * (angle / sine if sine > 1e-12 else 1))


def transform(r, p):
    return np.vstack([np.column_stack([r, p]), [0, 0, 0, 1]])


def turn(angle):
    return rotation([0, 0, angle])[:2, :2]


def numbers(element, key, default):
    text = None if element is None else element.get(key)
    return np.array([float(x) for x in (text or default).split()])


class Joint:
    def __init__(self, element):
        self.name, self.kind = element.get("name"), element.get("type")
        self.parent = element.find("parent").get("link")
        origin, limit = element.find("origin"), element.find("limit")
        roll, pitch, yaw = numbers(origin, "rpy", "0 0 0")
        turned = rotation([0, 0, yaw]) @ rotation([0, pitch, 0]) @ rotation([roll, 0, 0])
        self.origin = transform(turned, numbers(origin, "xyz", "0 0 0"))
        self.axis = numbers(element.find("axis"), "xyz", "1 0 0")
        self.rate = numbers(limit, "velocity", "inf")[0]
        ends = numbers(limit, "lower", "0")[0], numbers(limit, "upper", "0")[0]
        self.lower, self.upper = (-np.inf, np.inf) if self.kind == "continuous" else ends


class Robot:
    def __init__(self, entries, urdf):
        tree = xml.fromstring(urdf)
        above = {element.find("child").get("link"): Joint(element) for element in tree.findall("joint")}
        self.chain, link = [], entries["grasp_frame"]
        while link != entries["base_link"]:
            self.chain.insert(0, above[link])
            link = above[link].parent
        self.is_free = entries.get("drive") == "omnidirectional"
        named = entries["mecanum_wheels"] if self.is_free else [entries["left_wheel"], entries["right_wheel"]]
        wheels = [next((link, j) for link, j in above.items() if j.name == name) for name in named]
        middles = np.array([wheel.origin[:3, 3] for _, wheel in wheels])
        self.drive_from_base = transform(np.eye(3), -middles.mean(axis=0))
        if self.is_free:
            base = [entries["base_speed_limit_m_s"]] * 2 + [entries["base_turn_limit_rad_s"]]
        else:
            self.track = middles[0, 1] - middles[1, 1]
            link, wheel = wheels[0]
            shape = tree.find(f"link[@name='{link}']/collision/geometry/cylinder")
            base = [entries.get("wheel_rate_limit_rad_s", wheel.rate) * float(shape.get("radius"))] * 2
        self.base, joints = len(base), [joint for joint in self.chain if joint.kind != "fixed"]
        self.rates = np.array(base + [joint.rate for joint in joints])
        self.lower, self.upper = (np.array([getattr(j, end) for j in joints]) for end in ("lower", "upper"))

    def twist(self, inputs):
        """Velocity ahead and to the left, and turning rate, of the base."""
        if self.is_free:
            return np.array(inputs[:3])
        left, right = inputs[:2]
        return np.array([(left + right) / 2, 0, (right - left) / self.track])

    def inputs_between(self, begin, end, seconds):
        """The constant inputs that lead from one configuration to another; the base moves on an arc."""
        angle = (end[2] - begin[2] + np.pi) % (2 * np.pi) - np.pi
        way = turn(-begin[2] - angle / 2) @ (end[:2] - begin[:2]) / (seconds * np.sinc(angle / 2 / np.pi))
        rate = angle / seconds
        base = [*way, rate] if self.is_free else way[0] + np.array([-1, 1]) * self.track * rate / 2
        return np.append(base, (end[3:] - begin[3:]) / seconds)

    def kinematics(self, q):
        """The grasp's pose (relative to the height of the wheels' middles) and its whole-body Jacobian."""
        frame = transform(rotation([0, 0, q[2]]), [q[0], q[1], 0]) @ self.drive_from_base
        axes, positions = [], iter(q[3:])
        for joint in self.chain:
            frame = frame @ joint.origin
            if joint.kind == "fixed":
                continue
            axes.append((joint.kind, frame[:3, 3], frame[:3, :3] @ joint.axis))
            moved, none = joint.axis * next(positions), np.zeros(3)
            turned, shifted = (none, moved) if joint.kind == "prismatic" else (moved, none)
            frame = frame @ transform(rotation(turned), shifted)
        jacobian = np.zeros((6, len(self.rates)))
        x, y = frame[:2, 3] - q[:2]
        for i, (ahead, left, rate) in enumerate(map(self.twist, np.eye(self.base))):
            jacobian[:2, i] = turn(q[2]) @ [ahead, left] + rate * np.array([-y, x])
            jacobian[5, i] = rate
        for i, (kind, at, axis) in enumerate(axes, start=self.base):
            jacobian[:3, i] = axis if kind == "prismatic" else np.cross(axis, frame[:3, 3] - at)
            jacobian[3:, i] = 0 if kind == "prismatic" else axis
        return frame, jacobian
