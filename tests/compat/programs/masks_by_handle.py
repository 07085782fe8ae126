"""Someone who crops objects out of images: handles of shapes in the mask images, bounding boxes, points of one object."""

import numpy as np
from pyrep.const import ObjectType
from pyrep.objects.object import Object
from pyrep.objects.shape import Shape

from rlbench import Environment, ObservationConfig
from rlbench.action_modes.action_mode import MoveArmThenGripper
from rlbench.action_modes.arm_action_modes import JointPosition
from rlbench.action_modes.gripper_action_modes import Discrete
from rlbench.backend.utils import rgb_handles_to_mask
from rlbench.tasks import PickAndLift, StackBlocks


def box(mask, handle):
    rows, columns = np.nonzero(mask == handle)
    return None if len(rows) == 0 else (columns.min(), rows.min(), columns.max(), rows.max())


def points_match(shape, obs):
    """The points with a handle lie where the object is."""
    points = obs.overhead_point_cloud[obs.overhead_mask == shape.get_handle()]
    low_x, high_x, low_y, high_y, low_z, high_z = shape.get_bounding_box()
    reach = np.linalg.norm([max(-low_x, high_x), max(-low_y, high_y), max(-low_z, high_z)]) + 0.03
    off = np.linalg.norm(np.median(points, axis=0) - shape.get_position())
    assert off < reach, (shape.get_name(), off, reach)


def stack_blocks(task):
    _, obs = task.reset()
    handles = np.unique(obs.front_mask).astype(int)
    print("handles in the image:", handles)
    base = task._task.get_base()
    shapes = base.get_objects_in_tree(object_type=ObjectType.SHAPE, exclude_base=True)
    seen = {shape.get_name(): box(obs.overhead_mask, shape.get_handle()) for shape in shapes}
    print(seen)
    blocks = [shape for shape in shapes if seen[shape.get_name()] is not None]
    assert len(blocks) >= 4, seen
    assert len({shape.get_handle() for shape in shapes}) == len(shapes), "two shapes share a handle"
    for shape in blocks:
        points_match(shape, obs)

    # From handle to object and back.
    for shape in shapes:
        assert Object.get_object_name(shape.get_handle()) == shape.get_name()
        assert Shape(shape.get_name()) == shape
        assert Object.get_object_type(shape.get_name()) == ObjectType.SHAPE

    # Robot and table are in it too.
    robot = {visual.get_handle() for visual in task._robot.arm.get_visuals()}
    robot |= {s.get_handle() for s in Shape("Panda").get_objects_in_tree(ObjectType.SHAPE, exclude_base=False)}
    assert robot & set(handles), "the arm is not in the image"
    table = Shape("diningTable_visible").get_handle()
    assert (obs.front_mask == table).mean() > 0.05
    known = robot | {s.get_handle() for s in shapes} | {table}
    share = np.isin(obs.overhead_mask, list(known)).mean()
    assert share > 0.5, share

    # Handles stay when the episode begins anew.
    first = {shape.get_name(): shape.get_handle() for shape in shapes}
    task.reset()
    assert {name: Shape(name).get_handle() for name in first} == first
    return blocks


def pick_and_lift(task):
    _, obs = task.reset()
    names = [s.get_name() for s in task._task.get_base().get_objects_in_tree(object_type=ObjectType.SHAPE)]
    visible = [name for name in names if box(obs.overhead_mask, Shape(name).get_handle())]
    assert len(visible) >= 3, (names, visible)
    return visible


def main():
    np.random.seed(5)
    rgb = np.stack([np.full((2, 2), v) for v in (5, 1, 0)], axis=-1) / 255.0
    assert (rgb_handles_to_mask(rgb) == 5 + 256).all()
    obs_config = ObservationConfig()
    obs_config.set_all_high_dim(False)
    for camera in (obs_config.front_camera, obs_config.overhead_camera):
        camera.set_all(True)
        camera.image_size = (96, 96)
    env = Environment(MoveArmThenGripper(JointPosition(), Discrete()), obs_config=obs_config, headless=True)
    env.launch()
    blocks = stack_blocks(env.get_task(StackBlocks))
    visible = pick_and_lift(env.get_task(PickAndLift))
    print(len(blocks), "shapes of stack_blocks matched;", visible, "seen in pick_and_lift")
    env.shutdown()


if __name__ == "__main__":
    main()
