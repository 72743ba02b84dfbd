"""What the motors of a robot hold, in MuJoCo: an arm of the URDF with the same effort limits and a load at its grasp."""

import dataclasses
import xml.etree.ElementTree as ET

import mujoco
import numpy

# When a load begins to hang at the grasp, when all of it does, and until when it hangs (s)
BEGINS_S, HANGS_S, UNTIL_S = 0.5, 1.5, 4.0
GRAVITY = 9.81
# Stiffness and damping of a motor, by its limit: at the limit it is off by 1/3000 rad or m
STIFFNESS, DAMPING = 3000.0, 60.0


@dataclasses.dataclass
class Hung:
    """What a load does: how far it sags (m), and the arm's motor that is nearest to its limit, with its share. A motor at its
    limit yields, until the load falls or has a shorter lever."""

    sag: float
    joint: str
    share: float

    @property
    def yields(self) -> bool:
        return self.share > 0.9999


def readable(urdf: bytes) -> tuple[str, list[tuple[str, str, float, float]]]:
    """The text of a URDF for MuJoCo, without shapes, friction and mimics; and joint, leader, multiplier and offset of each mimic."""
    robot = ET.fromstring(urdf)
    mimics = []
    for link in robot.iter("link"):
        for part in [*link.findall("visual"), *link.findall("collision"), *link.findall("inertial")]:
            link.remove(part)
        # as weights are compensated, inertias matter only until the load is at rest
        inertial = ET.SubElement(link, "inertial")
        ET.SubElement(inertial, "mass", value="1")
        ET.SubElement(inertial, "inertia", ixx="0.01", iyy="0.01", izz="0.01", ixy="0", ixz="0", iyz="0")
    for joint in robot.findall("joint"):
        for element in [*joint.findall("dynamics"), *joint.findall("mimic")]:
            joint.remove(element)
            if element.tag == "mimic":
                mimics.append((joint.get("name"), element.get("joint"), float(element.get("multiplier", 1)), float(element.get("offset", 0))))
    for other in [*robot.findall("mujoco"), *robot.findall("transmission"), *robot.findall("gazebo"), *robot.findall("material")]:
        robot.remove(other)
    options = ET.SubElement(ET.SubElement(robot, "mujoco"), "compiler")
    options.attrib.update(fusestatic="false", discardvisual="false")
    return ET.tostring(robot, encoding="unicode"), mimics


def hung(urdf: bytes, grasp: tuple[str, numpy.ndarray], positions: dict[str, float], limits: dict[str, float], mass: float) -> Hung:
    """A load of this mass (kg) at a place in a link's frame, on an arm that starts in these positions (rad or m) and
    whose motors hold them within these limits (Nm or N). Links have no weight, as in the physical plant; every other
    joint is held without a limit."""
    text, mimics = readable(urdf)
    # what it warns of, such as equal limits, would go to a file here
    mujoco.set_mju_user_warning(lambda warning: None)
    spec = mujoco.MjSpec.from_string(text)
    spec.compiler.degree = False
    spec.option.timestep = 1e-3
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    led = {joint for joint, *_ in mimics}
    for body in spec.bodies:
        body.gravcomp = 1
    for joint in spec.joints:
        joint.actfrclimited, joint.limited = False, False
        if joint.name in led:
            continue
        motor = spec.add_actuator(name=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=joint.name)
        limit = limits.get(joint.name)
        size = 1e4 if limit is None else limit
        motor.set_to_position(kp=STIFFNESS * size, kv=DAMPING * size)
        if limit is not None:
            motor.forcelimited, motor.forcerange = True, [-limit, limit]
    for joint, leader, multiplier, offset in mimics:
        gear = spec.add_equality(type=mujoco.mjtEq.mjEQ_JOINT, objtype=mujoco.mjtObj.mjOBJ_JOINT, name1=joint, name2=leader)
        gear.data[:2] = offset, multiplier
        gear.solref = [0.004, 1]
    link, place = grasp
    load = spec.body(link).add_body(name="load", pos=place)
    load.mass, load.inertia, load.explicitinertial, load.gravcomp = 0.01, [1e-4] * 3, True, 1
    model = spec.compile()
    data = mujoco.MjData(model)
    for joint in spec.joints:
        data.joint(joint.name).qpos = positions.get(joint.name, 0.0)
        if joint.name not in led:
            data.actuator(joint.name).ctrl = positions.get(joint.name, 0.0)
    for joint, leader, multiplier, offset in mimics:
        data.joint(joint).qpos = multiplier * positions.get(leader, 0.0) + offset
    mujoco.mj_forward(model, data)
    height = data.body("load").xpos[2]
    while data.time < UNTIL_S:
        data.body("load").xfrc_applied[2] = -mass * GRAVITY * numpy.clip((data.time - BEGINS_S) / (HANGS_S - BEGINS_S), 0.0, 1.0)
        mujoco.mj_step(model, data)
        shares = {name: abs(data.actuator(name).force[0]) / limit for name, limit in limits.items()}
        joint = max(shares, key=shares.get)
        found = Hung(height - data.body("load").xpos[2], joint, shares[joint])
        # the first motor that yields: others may follow
        if data.time > BEGINS_S and found.yields:
            break
    return found
