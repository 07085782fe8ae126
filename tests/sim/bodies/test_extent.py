"""How far bodies reach along directions."""

from __future__ import annotations

import numpy as np

from rlbench_pin.robot.catalogue import robot_description
from rlbench_pin.scene.spec import BodySpec, SceneSpec
from rlbench_pin.sim import World
from rlbench_pin.spatial import euler_to_quaternion, pose_to_se3

ASSETS = ("cup/cup", "drop/drop", "convex/convex_03", "lever_door/lever_door", "stain/stain")
SCENE = SceneSpec(
    format=2,
    body=tuple(
        BodySpec(name=asset.split("/")[0], asset=f"objects/{asset}.urdf", pose=(0.3 * i, 0.1, 0.2, 0.5, 0.3, 0.2, 0.787401))
        for i, asset in enumerate(ASSETS)
    ),
)


def test_a_body_reaches_along_axes_as_far_as_its_box_along_them() -> None:
    """Boxes, cylinders, balls, hulls, several links."""
    frame = np.concatenate([np.zeros(3), euler_to_quaternion(0.3, -0.7, 1.9)])
    with World(SCENE, robot_description("panda")) as world:
        for body in world.bodies.values():
            reach = body.extent_along(pose_to_se3(frame).rotation.T)
            np.testing.assert_allclose(reach, body.bounds_from(frame), atol=1e-12, err_msg=body.name)


def test_the_box_of_a_body_of_one_link_is_the_same_wherever_it_is() -> None:
    """It is worked out once for each file, and everyone has a copy."""
    with World(SCENE, robot_description("panda")) as world:
        cup = world.body("cup")
        np.testing.assert_allclose(cup.bounds(), cup.bounds_from(cup.pose), atol=1e-12)
        cup.bounds()[:] = 0.0
        assert np.ptp(cup.bounds(), axis=0).min() > 0.05
