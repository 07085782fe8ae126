"""URDF files of arms and grippers that others publish, and grippers cut out of arms."""

from __future__ import annotations

import importlib.util
import xml.etree.ElementTree as ET
from pathlib import Path

from rlbench_pin.robot import robot_description


def robot_data() -> Path:
    """Return the folder of robots of example-robot-data, next to the installed cmeel packages."""
    spec = importlib.util.find_spec("cmeel") or importlib.util.find_spec("numpy")
    assert spec is not None and spec.origin is not None
    return Path(spec.origin).parents[1] / "cmeel.prefix/share/example-robot-data/robots"


Z1 = robot_data() / "z1_description/urdf/z1.urdf"
UR5 = robot_data() / "ur_description/urdf/ur5_robot.urdf"


def cut_out_gripper(robot: str, hand: str, file: Path) -> Path:
    """Write the gripper of an arm of the catalogue as makers publish theirs: the second finger follows the first, no tip frame."""
    urdf = robot_description(robot).urdf
    root = ET.parse(urdf).getroot()
    first, second = robot_description(robot).gripper_joints
    ends = {j.find("child").attrib["link"]: j.find("parent").attrib["link"] for j in root.iterfind("joint")}  # type: ignore[union-attr]
    tip = robot_description(robot).tip_frame

    def kept(link: str | None) -> bool:
        while link is not None and link != hand:
            link = None if link == tip else ends.get(link)
        return link == hand

    for element in list(root):
        link = element.get("name") if element.tag == "link" else element.find("child").attrib["link"]  # type: ignore[union-attr]
        if not kept(link) or (element.tag == "joint" and link == hand):
            root.remove(element)
    for joint in root.iterfind("joint"):
        mimic = joint.find("mimic")
        if joint.get("name") == second:
            ET.SubElement(joint, "mimic", joint=first)
        elif mimic is not None:
            mimic.set("joint", first)
    for mesh in root.iter("mesh"):
        mesh.set("filename", str(urdf.parent / mesh.attrib["filename"]))
    ET.ElementTree(root).write(file)
    return file
