"""The simulator, with the API of PyRep."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pyrep.const import ObjectType, Verbosity
from pyrep.errors import PyRepError, UnsupportedCall
from pyrep.objects.object import Object, views_of
from pyrep.objects.shape import Shape
from pyrep.textures import Texture, TextureHolder
from rlbench_pin.compat.joints import ConfigurationTree
from rlbench_pin.compat.simulator import Simulator
from rlbench_pin.robot import DEFAULT_ROBOT
from rlbench_pin.sim import read_texture

_OWN_SCENE = "task_design.ttt"
"""Name of the scene of the empty table."""


class PyRep:
    """Starts and steps the simulator. There is no window.

    Args:
        robot: Name of the arm in our catalogue.
    """

    def __init__(self, robot: str = DEFAULT_ROBOT) -> None:
        self.running, self._robot = False, robot
        self._simulator: Simulator | None = None

    # Start and end ---------------------------------------------------------------------------------------------------

    def launch(
        self,
        scene_file: str = "",
        headless: bool = False,
        responsive_ui: bool = False,
        blocking: bool = False,
        verbosity: Verbosity = Verbosity.NONE,
    ) -> None:
        """Start the simulator with the arm at an empty table.

        `scene_file` is empty, or the name of the empty table (`rlbench.backend.const.TTT_FILE`). All other arguments have no
        effect.

        Raises:
            PyRepError: The simulator is already running.
            UnsupportedCall: The file is a scene of another simulator.
        """
        if self._simulator is not None:
            raise PyRepError("The simulator is already running. Call `shutdown()` first.")
        if scene_file and Path(scene_file).name != _OWN_SCENE:
            raise UnsupportedCall(
                f"launch({scene_file!r})",
                "scenes of other simulators cannot be read.",
                "Launch without a file, and write a scene as TOML beside your task (`rlbench-pin new`).",
            )
        self._simulator = Simulator(self._robot)

    @property
    def simulator(self) -> Simulator:
        """The simulator.

        Raises:
            PyRepError: The simulator is not running.
        """
        if self._simulator is None:
            raise PyRepError("The simulator is not launched. Call `launch()` first.")
        return self._simulator

    def activate(self) -> None:
        """Make views refer to this simulator, if a program has several; environments do so at each call."""
        Simulator.make_current(self.simulator)

    def shutdown(self) -> None:
        """Close the simulator; further calls have no effect."""
        self.running = False
        if self._simulator is not None:
            self._simulator.close()
            self._simulator = None

    def start(self) -> None:
        """Start the simulation."""
        self.simulator.world.end_building()
        self.running = True

    def stop(self) -> None:
        """Stop the simulation; objects keep their poses."""
        self.running = False

    def step(self) -> None:
        """Advance by one control tick of 0.05 s, with the step of the task and the callbacks.

        Raises:
            PyRepError: `start` was not called.
        """
        runtime = self.simulator.runtime
        if not self.running:
            raise PyRepError("The simulation is stopped. Call `start()` first.")
        runtime.step()

    def step_ui(self) -> None:
        """No effect: there is no window, and images always show the current state."""

    def set_simulation_timestep(self, dt: float) -> None:
        """Warn if `dt` [s] is not the length of a control tick, which is fixed; physics steps are shorter."""
        tick = self.get_simulation_timestep()
        if abs(dt - tick) > 1e-9:
            warnings.warn(
                f"`set_simulation_timestep({dt})` changes nothing: a step stays {tick} s long, physics is finer inside. "
                "Step several times for a longer one.",
                stacklevel=2,
            )

    def get_simulation_timestep(self) -> float:
        """Return the length of a control tick [s]."""
        return self.simulator.world.control_dt

    # Objects ----------------------------------------------------------------------------------------------------------

    def get_objects_in_tree(
        self,
        root_object: Object | None = None,
        object_type: ObjectType = ObjectType.ALL,
        exclude_base: bool = True,
        first_generation_only: bool = False,
    ) -> list[Object]:
        """Return the descendants of an object.

        Args:
            root_object: The object; None is the world.
            object_type: Return only objects of this type.
            exclude_base: Leave out `root_object`.
            first_generation_only: Return only direct children.
        """
        if root_object is not None:
            return root_object.get_objects_in_tree(object_type, exclude_base, first_generation_only)
        table = self.simulator.objects
        elements = list(table.elements())
        return views_of(table.children(None) if first_generation_only else elements, object_type)

    def create_texture(
        self,
        filename: str,
        interpolate: bool = True,
        decal_mode: bool = False,
        repeat_along_u: bool = False,
        repeat_along_v: bool = False,
    ) -> tuple[TextureHolder, Texture]:
        """Read an image for `Shape.set_texture`. Only `filename` has an effect.

        Returns:
            A placeholder for the shape that holds a texture in other simulators, and the texture.

        Raises:
            CameraError: The file cannot be read as an image.
        """
        read_texture(Path(filename))
        return TextureHolder(), Texture(str(filename))

    def set_configuration_tree(self, config_tree: ConfigurationTree) -> None:
        """Restore a configuration from `Object.get_configuration_tree`, with velocity 0."""
        config_tree.write(self.simulator.objects)

    def group_objects(self, objects: Sequence[Shape]) -> Shape:
        """Raise UnsupportedCall: bodies are not joined at run time."""
        raise UnsupportedCall(
            "group_objects",
            "bodies are not joined at run time.",
            "Make one with several links as URDF, or hang one on the other.",
        )

    def merge_objects(self, objects: Sequence[Shape]) -> Shape:
        """Raise UnsupportedCall: bodies are not joined at run time."""
        raise UnsupportedCall(
            "merge_objects", "bodies are not joined at run time.", "Join the meshes first, then `Shape.create_mesh`."
        )

    def import_model(self, filename: str) -> Object:
        """Raise UnsupportedCall: ttm models cannot be read."""
        raise UnsupportedCall(
            f"import_model({filename!r})",
            "models of other simulators cannot be read.",
            "Write the model as URDF and name it in a scene file, or use `Shape.import_mesh`.",
        )

    def export_scene(self, filename: str) -> None:
        """Raise UnsupportedCall: ttt scenes cannot be written."""
        raise UnsupportedCall(
            f"export_scene({filename!r})", "scenes are TOML files.", "Write one with `rlbench-pin new`, or keep `World.arrays()`."
        )

    def script_call(
        self,
        function_name_at_script_name: str,
        script_handle_or_type: int,
        ints: Sequence[int] = (),
        floats: Sequence[float] = (),
        strings: Sequence[str] = (),
        bytes: str = "",
    ) -> Any:
        """Raise UnsupportedCall: scenes have no scripts."""
        raise UnsupportedCall(
            f"script_call({function_name_at_script_name!r})", "Lua scripts are not supported.", "Write the function in Python."
        )
