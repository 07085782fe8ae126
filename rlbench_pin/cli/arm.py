"""`rlbench-pin arm new|check`: make a custom arm from a URDF file, and check it."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from rlbench_pin.cli.options import MaybePath, check_at_least
from rlbench_pin.errors import MissingExtra

if TYPE_CHECKING:
    from rlbench_pin.builder.custom_assets.arm_folder import NewArm
    from rlbench_pin.checking.arms import ArmCheck

NewName = tyro.conf.Positional[Annotated[str, tyro.conf.arg(metavar="NAME")]]
AnyArm = tyro.conf.Positional[Annotated[str, tyro.conf.arg(metavar="ARM|FILE")]]
Place = Annotated[
    tuple[float, float, float, float, float, float] | None, tyro.conf.arg(metavar="X Y Z ROLL PITCH YAW", help_behavior_hint="")
]
_MARKS = {True: "ok", False: "FAILED", None: "-"}


@dataclass(frozen=True)
class NewArmFolder:
    """Make an arm from a URDF file: the folder NAME with NAME.toml, NAME.urdf, NAME.srdf and meshes. No other file is needed.

    Example: `rlbench-pin arm new my_arm --urdf description/urdf/my_arm.urdf`, then `rlbench-pin arm check my_arm/my_arm.toml`.
    """

    name: NewName
    """Name of the arm: lower case letters, digits and `_`."""
    urdf: Path
    """URDF file of the arm. `xacro file.xacro > file.urdf` converts a XACRO file."""
    gripper: MaybePath = None
    """URDF file of a gripper with two fingers; z points out of its base. Default: the parallel gripper of the xArm7."""
    flange: Annotated[str, tyro.conf.arg(metavar="LINK", help_behavior_hint="")] = ""
    """Link that carries the gripper. Links below it, such as a gripper in the URDF, are left out. Default: the last link."""
    mount: Place = None
    """Pose of the gripper's base in the frame of the flange [m], [rad]. Default: at the end of that link, along the axis of the
    last joint, rotated for the largest reach."""
    out: Path = Path()
    """Folder in which the folder NAME is created."""

    def run(self) -> int:
        """Write the folder, and print what was found, what is missing, and what to do next."""
        try:
            from rlbench_pin.builder.custom_assets.arm_folder import STEPS, make_arm
        except ModuleNotFoundError as error:
            raise MissingExtra("`rlbench-pin arm new`", error.name or "trimesh", "builder") from error
        from rlbench_pin.cli.bars import progress_bar

        with progress_bar(total=STEPS, unit="step", desc=self.name) as bar:

            def note(step: str) -> None:
                bar.set_postfix_str(step)
                bar.update()

            made = make_arm(self.name, self.urdf, self.out, self.gripper, self.flange, self.mount, note)
        print(_summary(made))
        return 0


@dataclass(frozen=True)
class CheckArm:
    """Check the models, inverse kinematics, gripper and limits of an arm, and its demonstrations of two tasks.

    Example: `rlbench-pin arm check my_arm/my_arm.toml`, or `rlbench-pin arm check panda`. It takes about a minute. Exit code 1: a
    check failed.
    """

    arm: AnyArm
    """Name of an arm, or path of its TOML file."""
    actions: int = 300
    """Number of random actions that are sent through the safety filter."""

    def run(self) -> int:
        """Print a line for each check; return 1 when one fails."""
        from rlbench_pin.checking.arms import CHECKS, check_arm
        from rlbench_pin.cli.bars import progress_bar
        from rlbench_pin.robot import RobotModel, robot_description

        check_at_least(self, actions=1)
        description = robot_description(self.arm)
        RobotModel(description)  # a description that does not fit its URDF ends here
        found = []
        with progress_bar(total=len(CHECKS), unit="check", desc=description.name) as bar:
            bar.set_postfix_str(CHECKS[0][0])
            for check in check_arm(description, self.actions):
                found.append(check)
                bar.set_postfix_str("" if len(found) == len(CHECKS) else CHECKS[len(found)][0])
                bar.update()
        print(_table(found))
        failed = sum(check.passed is False for check in found)
        print(f"{description.name}: {f'{failed} of {len(found)} checks failed' if failed else 'all checks passed'}")
        return 1 if failed else 0


@dataclass(frozen=True)
class Arm:
    """Make a custom arm from a URDF file, and check it. Other commands take its file: `--robot my_arm/my_arm.toml`."""

    action: tyro.conf.OmitSubcommandPrefixes[
        Annotated[NewArmFolder, tyro.conf.subcommand("new")] | Annotated[CheckArm, tyro.conf.subcommand("check")]
    ] = field()
    """Subcommand."""

    def run(self) -> int:
        """Run the subcommand."""
        return self.action.run()


def _summary(made: NewArm) -> str:
    description, (reached, places) = made.description, made.reached
    x, y, z = description.base_pose[:3]
    mount = " ".join(f"{number:.4g}" for number in (*made.mount.xyz + 0.0, *made.mount.rpy + 0.0))
    lines = [
        str(made.file),
        f"{len(description.arm_joints)} joints: {', '.join(description.arm_joints)}",
        f"gripper on '{made.flange}', --mount {mount}",
        f"base at ({x:g}, {y:g}, {z:g}) m; from above the gripper reaches {reached} of {places} places of the workspace",
        f"home: {', '.join(f'{angle:g}' for angle in description.home)}",
    ]
    if made.missing:
        lines += ["Not in the URDF. Look these values up and change them:", *(f"  {line}" for line in made.missing)]
    return "\n".join([*lines, f"Next: rlbench-pin arm check {made.file}"])


def _table(checks: list[ArmCheck]) -> str:
    width = max(len(check.name) for check in checks)
    lines = []
    for check in checks:
        lines.append(f"{check.name.ljust(width)}  {_MARKS[check.passed].ljust(6)}  {check.figure}")
        if check.advice:
            lines.append(f"{' ' * width}          {check.advice}")
    return "\n".join(lines)
