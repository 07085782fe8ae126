"""Scenes and motions that the simulation tests share."""

from __future__ import annotations

import numpy as np

from rlbench_pin.robot.description import robot_description
from rlbench_pin.scene.spec import BodySpec, FrameSpec, JointSpec, RegionSpec, SceneSpec, SensorSpec, SpringSpec
from rlbench_pin.sim import World
from rlbench_pin.sim.resting import QUIET_TICKS
from rlbench_pin.spatial import above_table

PANDA = robot_description("panda")
HOME = np.array(PANDA.home)
ABOVE = np.array([0.0, 0.327683, 0.0, -2.135615, 0.0, 2.463298, 0.785398])
"""Tip 0.148 m above the table at x = 0.3, y = 0, pointing down."""
AROUND = np.array([0.0, 0.599395, 0.0, -2.100885, 0.0, 2.700281, 0.785398])
"""The same, 0.025 m above the table: around a cube that stands there."""
UPRIGHT = (0.0, 0.0, 0.0, 1.0)
SIDE = 0.05
"""Of a cube [m]."""
FAR = (0.1, 0.35)
"""Where towers stand, away from the arm."""


def cube(name: str, x: float, y: float, z: float = above_table(0.025), **keys: object) -> BodySpec:
    """A cube of side 0.05 m, in world coordinates."""
    return BodySpec(name=name, asset="objects/cube/cube.urdf", parent="world", pose=(x, y, z, *UPRIGHT), **keys)


def cube_scene(*cubes: BodySpec) -> SceneSpec:
    """A scene of cubes; by default one between the fingers at `AROUND`."""
    return SceneSpec(format=1, body=cubes or (cube("cube", 0.3, 0.0),))


def furniture_scene() -> SceneSpec:
    """A button and a chest on the root, with frames, a region and a sensor."""
    return SceneSpec(
        format=1,
        body=(
            BodySpec(name="button", asset="objects/button/button.urdf", fixed=True, pose=(0.05, -0.2, 0.0, *UPRIGHT)),
            BodySpec(name="chest", asset="objects/chest/chest.urdf", fixed=True, pose=(0.3, 0.2, 0.0, *UPRIGHT)),
            BodySpec(name="cube", asset="objects/cube/cube.urdf", parent="spot", pose=(0.0, 0.0, 0.025, *UPRIGHT)),
        ),
        joint=(
            JointSpec(name="button/cap_joint", spring=SpringSpec(stiffness=300.0, damping=1.0)),
            JointSpec(name="chest/drawer_top", friction=2.0, position=0.1),
            JointSpec(name="chest/drawer_middle", locked=True, position=0.05),
        ),
        frame=(
            FrameSpec(name="spot", pose=(-0.05, 0.1, 0.0, *UPRIGHT)),
            FrameSpec(name="knob", parent="chest/drawer_top_link", pose=(-0.05, 0.0, 0.0, *UPRIGHT)),
            FrameSpec(name="corner", parent="world", pose=(0.1, 0.2, 0.8, *UPRIGHT)),
        ),
        region=(RegionSpec(name="patch", pose=(0.0, 0.0, 0.0, *UPRIGHT), size=(0.2, 0.1, 0.0)),),
        sensor=(
            SensorSpec(name="detector", parent="spot", shape="box", size=(0.02, 0.02, 0.02), pose=(0.0, 0.0, 0.01, *UPRIGHT)),
        ),
    )


def build(scene: SceneSpec | None = None) -> World:
    """A running world."""
    return World(scene or cube_scene(), PANDA)


def move(world: World, q: np.ndarray, seconds: float = 1.0) -> None:
    """Drive the arm along a smooth joint path."""
    start, ticks = world.robot.joint_positions, round(seconds / world.control_dt)
    for k in range(1, ticks + 1):
        s = k / ticks
        world.robot.set_position_targets(start + (q - start) * (10 * s**3 - 15 * s**4 + 6 * s**5))
        world.step()


def steps(world: World, ticks: int) -> None:
    """Let time pass."""
    for _ in range(ticks):
        world.step()


def fingers(world: World, amount: float, speed: float = 0.04) -> int:
    """Drive the fingers until they stop; return the ticks it took."""
    world.gripper.set_target(amount, speed)
    for tick in range(60):
        world.step()
        if tick > 0 and not world.gripper.moving:
            return tick + 1
    raise AssertionError("the fingers did not stop")


def close_on_cube(world: World) -> None:
    """Close the gripper on the cube of `cube_scene`."""
    world.robot.reset_configuration(ABOVE)
    move(world, AROUND)
    fingers(world, 0.0)


def digest(world: World) -> bytes:
    """Everything that moves, to the last bit."""
    parts = [np.concatenate([body.pose, body.velocity]) for body in world.bodies.values()]
    joints = [np.array(joint.state()) for body in world.bodies.values() for joint in body.joints.values()]
    return b"".join(a.tobytes() for a in (*parts, *joints, world.robot.joint_states()))


def tower_scene(height: int = 3) -> SceneSpec:
    """A tower of cubes, and a cube beside it."""
    cubes = [cube(f"t{k}", *FAR, above_table(SIDE * (k + 0.5))) for k in range(height)]
    return cube_scene(*cubes, cube("beside", 0.1, -0.35))


def asleep(world: World) -> set[str]:
    """Names of what sleeps."""
    return {name for name, ticks in world.resting.quiet if ticks == QUIET_TICKS}


def fall_asleep(world: World, ticks: int = 40) -> None:
    """Step until everything sleeps."""
    for _ in range(ticks):
        world.step()
        if asleep(world) == set(world.bodies):
            return
    raise AssertionError(f"only {asleep(world)} sleep after {ticks} ticks")
