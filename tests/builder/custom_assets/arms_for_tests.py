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
    """Write the gripper of an arm of the catalogue as makers publish theirs: the second finger follows the first."""
    description = robot_description(robot)
    root = ET.parse(description.urdf).getroot()
    first, second = description.gripper_joints
    parents = {_end(joint, "child"): _end(joint, "parent") for joint in root.iterfind("joint")}

    def is_kept(link: str) -> bool:
        while link in parents and link not in (hand, description.tip_frame):
            link = parents[link]
        return link == hand

    for element in list(root):
        link = element.attrib["name"] if element.tag == "link" else _end(element, "child")
        if not is_kept(link) or (element.tag == "joint" and link == hand):
            root.remove(element)
    for joint in root.iterfind("joint"):
        mimic = joint.find("mimic")
        if joint.get("name") == second:
            ET.SubElement(joint, "mimic", joint=first)
        elif mimic is not None:
            mimic.set("joint", first)
    for mesh in root.iter("mesh"):
        mesh.set("filename", str(description.urdf.parent / mesh.attrib["filename"]))
    ET.ElementTree(root).write(file)
    return file


def _end(joint: ET.Element, end: str) -> str:
    element = joint.find(end)
    assert element is not None
    return element.attrib["link"]
