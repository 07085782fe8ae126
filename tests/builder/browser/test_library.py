"""The browser shows every task of the library as the overhead camera of the simulation sees it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from scipy.ndimage import binary_dilation
from selenium.webdriver import Chrome
from viser import ClientHandle, ViserServer

from rlbench_pin.builder.server import LocalServer
from rlbench_pin.environment.observations.config import CameraConfig
from rlbench_pin.environment.observations.observe import camera_view
from rlbench_pin.robot import robot_description
from rlbench_pin.scene import SceneSpec, read_scene
from rlbench_pin.sim import CameraView
from rlbench_pin.sim.world import World
from rlbench_pin.spatial import compose
from rlbench_pin.tasks.registry import LIBRARY
from rlbench_pin.viewer.figures import Figures
from tests.builder.browser.conftest import IMAGES
from tests.builder.browser.page import Page, until
from tests.builder.document.conftest import EDITABLE

SIDE = 320
DIFFERING = 0.02
"""Share of pixels that one of the two alone sees, borders of a pixel apart."""
STRINGS = {"hockey": 0.05}
"""Where a net of strings thinner than a pixel is seen: another share."""
BORDER = np.ones((3, 3), dtype=bool)
BACK = 2.8
"""Turn of the first joint that brings the arm out of sight [rad]."""
SOME = ("open_drawer", "play_jenga", "light_bulb_in", "put_groceries_in_cupboard", "take_lid_off_saucepan", "straighten_rope")
HALF_TURN = (0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0)
"""From our camera frame, x to the left and y up, to the browser's, x to the right and y down."""
Mask = NDArray[np.bool_]


class Easel:
    """Figures alone, before the overhead camera of a browser.

    Args:
        viser: The page.
        client: The browser's tab.
        figures: What is drawn.
    """

    def __init__(self, viser: ViserServer, client: ClientHandle, figures: Figures) -> None:
        self._viser, self._client, self._figures = viser, client, figures
        for part in ("/room", "/arm"):
            viser.scene.add_frame(part, show_axes=False, visible=False)

    def silhouette(self, spec: SceneSpec, camera: CameraView) -> Mask:
        """Return where bodies of a scene are seen, shape (side, side)."""
        assert self._figures.show(spec) == {}
        x, y, z, *turn = compose(camera.pose, HALF_TURN)
        wxyz = (turn[3], *turn[:3])
        self._viser.flush()
        image = self._client.get_render(
            SIDE, SIDE, wxyz=wxyz, position=(x, y, z), fov=camera.fov, transport_format="png", timeout=60.0
        )
        return image[..., 3] > 127


@pytest.fixture(scope="module")
def easel(shared_browser: Chrome) -> Iterator[Easel]:
    """One browser for all tasks."""
    with LocalServer() as server:
        figures = Figures(server.viser.scene)
        Page(shared_browser, server.viser, IMAGES).open(server.address)
        client = until(lambda: next(iter(server.viser.get_clients().values()), None), "a client")
        assert client is not None
        yield Easel(server.viser, client, figures)


def simulated(spec: SceneSpec) -> tuple[CameraView, Mask]:
    """Return the overhead camera, and where it sees bodies of a scene in simulation with the arm turned out of its sight."""
    robot = robot_description("panda")
    with World(spec, robot) as world:
        world.robot.reset_configuration(np.array([BACK, *robot.home[1:]]))
        camera = camera_view("overhead", CameraConfig(image_size=(SIDE, SIDE)), world, robot)
        mask = world.render(camera, rgb=False, depth=False).mask
        bodies = [number for number, name in world.masks.items() if name.partition("/")[0] in world.bodies]
    assert mask is not None
    return camera, np.isin(mask, bodies)


def differing(easel: Easel, task: str) -> float:
    """Return how many pixels one silhouette has more than a pixel away from the other, per pixel of both."""
    spec = read_scene(LIBRARY / f"{task}.toml")
    camera, ours = simulated(spec)
    theirs = easel.silhouette(spec, camera)
    wrong = (ours & ~binary_dilation(theirs, BORDER)) | (theirs & ~binary_dilation(ours, BORDER))
    share = float(wrong.sum() / max(1, (ours | theirs).sum()))
    if share >= STRINGS.get(task, DIFFERING):
        IMAGES.mkdir(parents=True, exist_ok=True)
        shown = np.stack([ours, theirs, ours & theirs], axis=-1).astype(np.uint8) * 255
        Image.fromarray(shown).save(IMAGES / f"silhouettes_{task}.png")
    return share


@pytest.mark.parametrize("task", SOME)
def test_the_scene_is_the_simulated_one(easel: Easel, task: str) -> None:
    """Red where the simulation alone sees something, green where the browser alone does, in the image that is kept."""
    assert differing(easel, task) < STRINGS.get(task, DIFFERING)


@pytest.mark.slow
@pytest.mark.parametrize("task", sorted(set(EDITABLE) - set(SOME)))
def test_every_scene_is_the_simulated_one(easel: Easel, task: str) -> None:
    """All others."""
    assert differing(easel, task) < STRINGS.get(task, DIFFERING)
