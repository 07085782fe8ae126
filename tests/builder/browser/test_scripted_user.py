"""A person builds a pick-and-place task from nothing, tries it, validates it and saves it; what is kept passes the validator."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from rlbench_pin.builder.document import TaskDocument
from rlbench_pin.scene import WaypointSpec
from tests.builder.browser.conftest import Desk, Sit
from tests.builder.browser.page import Page, until

SENTENCES = (
    "Put the cube on the green square.",
    "There is a square on the table: the cube belongs on it.",
    "Pick the cube up and set it down on the marked place.",
)


def test_a_task_from_nothing(sit: Sit, tmp_path: Path) -> None:
    """Bodies, a gizmo, waypoints, success, sentences, a demonstration, the validator, two files that a reviewer takes."""
    document = TaskDocument.new(tmp_path, "set_cube_on_square")
    desk = sit(document)
    desk.page.quiet()
    _add_bodies(desk)
    _drag_square(desk)
    _add_sensor(desk)
    _add_waypoints(desk)
    _say_what_is_asked(desk)
    _try(desk)
    _validate(desk)
    page = desk.page
    page.tab("Scene")
    page.press("Save")
    until(lambda: not document.unsaved, "saved")
    page.tab("Validate")
    page.screenshot("8_saved")
    command = [
        sys.executable,
        "-m",
        "rlbench_pin.cli.main",
        "check",
        "--task-file",
        str(tmp_path / "set_cube_on_square.py"),
        "--episodes",
        "3",
    ]
    checked = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert checked.returncode == 0, checked.stdout + checked.stderr


def _add_bodies(desk: Desk) -> None:
    page, document = desk.page, desk.document
    page.tab("Add")
    page.type("Search", "target_square")
    page.press("Add target_square")
    until(lambda: "target_square.urdf" in document.scene_text, "the square")
    page.type("Search", "cube_45")
    page.press("Add cube_45")
    until(lambda: "cube_45.urdf" in document.scene_text, "the cube")
    page.screenshot("1_added")
    page.tab("Selected")
    _rename(page, "cube")
    page.tab("Scene")
    page.press("■ target_square")
    page.shows("### target_square".removeprefix("### "))
    _rename(page, "square")


def _drag_square(desk: Desk) -> None:
    page, session = desk.page, desk.session
    desk.settle()
    page.press("■ square")
    until(lambda: session.selected == "square", "the square is selected")
    desk.settle()
    start = session.places.elements["square"][:3].copy()
    page.drag(start + (0.0, 0.125, 0.0), start + (0.0, 0.275, 0.0))
    until(
        lambda: session.places.elements["square"][1] > start[1] + 0.08 and not desk.window.view.is_dragging,
        "the square has moved",
    )
    page.screenshot("2_dragged")
    page.type("x y z [m]", "0.05", 1)
    until(lambda: abs(session.places.elements["square"][0] - 0.3) < 1e-6, "the number counts")


def _rename(page: Page, name: str) -> None:
    """Call what is selected otherwise, and wait until the page does so: its fields are made anew then."""
    page.type("Name", name)
    page.press("Rename")
    until(
        lambda: name in [title.text for title in page.browser.find_elements("xpath", "//h1 | //h2 | //h3")], f"'{name}' as title"
    )


def _add_sensor(desk: Desk) -> None:
    page, document = desk.page, desk.document
    page.tab("Add")
    page.press("Add sensor")
    until(lambda: "[[sensor]]" in document.scene_text, "the sensor")
    _rename(page, "goal")
    page.choose("Shape", "cylinder")
    page.type("Diameter [m]", "0.08")
    page.type("Length [m]", "0.05")
    page.type("x y z [m]", "0.03", 3)
    until(lambda: "size = [0.08, 0.05]" in document.scene_text, "the size of the sensor")
    page.screenshot("3_sensor")


def _add_waypoints(desk: Desk) -> None:
    _waypoint(desk, "cube", 0, "0.1")
    _waypoint(desk, "cube", 1, "0")
    desk.page.choose("Gripper", "close")
    _waypoint(desk, "cube", 2, "0.1")
    desk.page.check("Ignore collisions")
    _waypoint(desk, "square", 3, "0.12")
    desk.page.check("Ignore collisions")
    _waypoint(desk, "square", 4, "0.03")
    desk.page.check("Ignore collisions")
    desk.page.choose("Gripper", "open")
    until(lambda: 'gripper = "open"' in desk.document.scene_text, "the hand opens")
    desk.settle()
    until(lambda: all(v.standing == "free" for v in desk.session.status.verdicts.values()), "all waypoints are green")
    assert len(desk.session.status.verdicts) == 5
    desk.page.screenshot("4_waypoints")


def _waypoint(desk: Desk, parent: str, number: int, height: str) -> None:
    """Add a waypoint at the tip, and put it above the middle of a body."""
    page, session, name = desk.page, desk.session, f"waypoint{number}"
    page.tab("Scene")
    page.press(f"■ {parent}")
    until(lambda: session.selected == parent, "the parent is selected")
    page.tab("Add")
    page.press("Add waypoint at the tip")
    until(lambda: session.selected == name, "the waypoint is selected")
    desk.settle()
    page.shows(name)

    def has_numbers() -> bool:
        waypoint = session.element(name)
        return isinstance(waypoint, WaypointSpec) and waypoint.symmetry == 4 and abs(waypoint.pose[2] - float(height)) < 1e-6

    def type_numbers() -> bool:
        """A busy page may replace a field while a key is pressed: a person then types the number again."""
        for k, text in enumerate(("0", "0", height), 1):
            page.type("x y z [m]", text, k)
        for k, text in enumerate(("180", "0", "0"), 1):
            page.type("roll pitch yaw [deg]", text, k)
        page.type("Symmetry", "4")
        desk.settle()
        return has_numbers()

    until(type_numbers, "its numbers")


def _say_what_is_asked(desk: Desk) -> None:
    page, document = desk.page, desk.document
    page.tab("Behaviour")
    page.type("Title", "Set a cube on a square.")
    page.press("Apply title")
    page.type("Variations and success", "The cube has to lie on the square, let go. The two stand anywhere together.")
    page.press("Apply description")
    page.type("Sentences, one per line", "\n".join(SENTENCES))
    page.press("Apply sentences")
    page.check("cube")
    until(lambda: document.behaviour.graspable == ("cube",), "the cube may be grasped")
    page.fold("Add condition")
    page.press("Detected")
    until(lambda: len(document.behaviour.success or ()) == 1, "the first condition")
    page.press("NothingGrasped")
    until(lambda: len(document.behaviour.success or ()) == 2, "the second condition")
    page.screenshot("5_behaviour")
    page.tab("Files")
    page.screenshot("5_files")


def _try(desk: Desk) -> None:
    page, session = desk.page, desk.session
    page.tab("Try")
    until(lambda: session.status.opened is not None and len(session.status.opened.conditions) == 2, "the task runs")
    page.press("Demonstration")
    until(lambda: desk.window.player.recording.frames and desk.window.player.recording.frames[-1].success, "success", 180.0)
    page.shows("Playback")
    page.screenshot("6_demonstration")


def _validate(desk: Desk) -> None:
    page, validation = desk.page, desk.window.validation
    page.tab("Validate")
    page.type("Demonstrations", "3")
    page.press("Validate")
    until(lambda: validation.work, "validating")
    until(lambda: not validation.work, "validated", 600.0)
    page.screenshot("7_validated")
    assert validation.lines
    assert {line.name: line.failures for line in validation.lines.values() if not line.passed} == {}
