"""A robot with the object in its grasp as pinocchio has it from the URDF: what the export must be.

Links that do not move against each other are one body. Every body of the robot has 1e-5 kg m^2 more about its centre of
mass, and at least 10 g, as the book says.
"""

import tomllib
import xml.etree.ElementTree as xml
from pathlib import Path

import numpy as np
import pinocchio as pin

MIN_MASS, MIN_INERTIA = 0.01, 1e-5


class Reference:
    """`joints` are the names of the arm's joints, in the order of the program."""

    def __init__(self, robot_file: Path, said: dict, size: list[float], mass: float):
        entries = tomllib.loads(robot_file.read_text())
        urdf = robot_file.parent / entries["urdf"]
        self.joints = [joint["name"] for joint in said["joints"]]
        whole = pin.buildModelFromUrdf(str(urdf))
        self.whole, held = whole, pin.neutral(whole)
        positions = {name: hold.get("position_m", np.radians(hold.get("angle_deg", 0.0))) for name, hold in entries.get("hold", {}).items()}
        for joint in xml.parse(urdf).getroot().findall("joint"):
            mimic = joint.find("mimic")
            if mimic is not None and mimic.get("joint") in positions:
                positions[joint.get("name")] = float(mimic.get("multiplier", 1)) * positions[mimic.get("joint")] + float(mimic.get("offset", 0))
        for name, position in positions.items():
            self._set(whole, held, name, position)
        locked = [i for i, name in enumerate(whole.names) if i and name not in self.joints]
        reduced = pin.buildReducedModel(whole, locked, held)

        data = whole.createData()
        pin.framesForwardKinematics(whole, data, held)
        root_from_base = data.oMf[whole.getFrameId(said["base"]["link"])]
        self.drive_from_root = pin.SE3(np.array(said["base"]["drive_from_base"])) * root_from_base.inverse()

        self.model = model = pin.Model()
        base = model.addJoint(0, pin.JointModelPlanar(), pin.SE3.Identity(), "base")
        model.appendBodyToJoint(base, self._body(self.drive_from_root.act(reduced.inertias[0])), pin.SE3.Identity())
        number = {0: base}
        for i in range(1, reduced.njoints):
            parent, placement = reduced.parents[i], reduced.jointPlacements[i]
            placement = self.drive_from_root * placement if parent == 0 else placement
            number[i] = model.addJoint(number[parent], reduced.joints[i], placement, reduced.names[i])
            model.appendBodyToJoint(number[i], self._body(reduced.inertias[i]), pin.SE3.Identity())
        grasp = reduced.frames[reduced.getFrameId(said["grasp_frame"])]
        self.holder = number[grasp.parentJoint]
        self.holder_from_grasp = grasp.placement if grasp.parentJoint else self.drive_from_root * grasp.placement
        grip = model.addJoint(self.holder, pin.JointModelTranslation(), self.holder_from_grasp, "grip")
        turn = model.addJoint(grip, pin.JointModelSpherical(), pin.SE3.Identity(), "grip_turn")
        box = mass / 12 * np.diag([size[1] ** 2 + size[2] ** 2, size[0] ** 2 + size[2] ** 2, size[0] ** 2 + size[1] ** 2])
        model.appendBodyToJoint(turn, pin.Inertia(mass, np.array([size[0] / 2, 0, 0]), box), pin.SE3.Identity())
        self.data = model.createData()
        self.held, self.urdf = held, urdf

    @staticmethod
    def _body(inertia: pin.Inertia) -> pin.Inertia:
        return pin.Inertia(max(inertia.mass, MIN_MASS), inertia.lever, inertia.inertia + MIN_INERTIA * np.eye(3))

    @staticmethod
    def _set(model: pin.Model, q: np.ndarray, name: str, position: float) -> None:
        i = model.getJointId(name)
        at, is_turn = model.idx_qs[i], model.nqs[i] == 2
        q[at : at + model.nqs[i]] = [np.cos(position), np.sin(position)] if is_turn else position

    def configuration(self, base: np.ndarray, joints: dict[str, float], place: np.ndarray, turn: np.ndarray) -> np.ndarray:
        """Base x, y, yaw; joints; place and quaternion (w, x, y, z) of the object's rear end in the grasp."""
        q = pin.neutral(self.model)
        q[:4] = [base[0], base[1], np.cos(base[2]), np.sin(base[2])]
        for name, position in joints.items():
            self._set(self.model, q, name, position)
        at = self.model.idx_qs[self.model.getJointId("grip")]
        q[at : at + 3], q[at + 3 : at + 7] = place, np.roll(turn, -1)
        return q

    def mass_matrix(self, q: np.ndarray, names: list[str]) -> np.ndarray:
        """In the order: base x, y (world), yaw; the joints of these names; place and turn of the object."""
        full = pin.crba(self.model, self.data, q)
        full = np.triu(full) + np.triu(full, 1).T
        velocity = np.eye(self.model.nv)
        c, s = q[2], q[3]
        velocity[:2, :2] = [[c, s], [-s, c]]
        full = velocity.T @ full @ velocity
        index = [*range(3), *(self.model.idx_vs[self.model.getJointId(name)] for name in names)]
        at = self.model.idx_vs[self.model.getJointId("grip")]
        index += range(at, at + 6)
        return full[np.ix_(index, index)]

    def bodies(self, q: np.ndarray) -> dict[str, tuple[pin.SE3, pin.Inertia]]:
        """Pose and inertia of the base ("base") and of what each joint moves, by its name."""
        pin.forwardKinematics(self.model, self.data, q)
        names = self.model.names
        return {names[i]: (self.data.oMi[i], self.model.inertias[i]) for i in range(1, self.model.njoints)}

    def shapes(self, base: np.ndarray, joints: dict[str, float]) -> dict[str, list[pin.SE3]]:
        """The pose of every collision shape of every link, as the URDF has it."""
        q = self.held.copy()
        for name, position in joints.items():
            self._set(self.whole, q, name, position)
        data = self.whole.createData()
        pin.framesForwardKinematics(self.whole, data, q)
        c, s = np.cos(base[2]), np.sin(base[2])
        world_from_drive = pin.SE3(np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]), np.array([base[0], base[1], 0]))
        found = {}
        for link in xml.parse(self.urdf).getroot().findall("link"):
            world_from_link = world_from_drive * self.drive_from_root * data.oMf[self.whole.getFrameId(link.get("name"))]
            for shape in link.findall("collision"):
                origin = shape.find("origin")
                numbers = lambda key: np.array([float(x) for x in (origin.get(key, "0 0 0") if origin is not None else "0 0 0").split()])
                at = pin.SE3(pin.rpy.rpyToMatrix(*numbers("rpy")), numbers("xyz"))
                found.setdefault(link.get("name"), []).append(world_from_link * at)
        return found
