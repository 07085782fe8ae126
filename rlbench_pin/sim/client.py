"""The one place that imports pybullet, and the client that owns one physics server."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import Any, NoReturn

import pinocchio as pin

from rlbench_pin.errors import AssetInvalid, AssetNotFound, EnvironmentClosed, UnknownName
from rlbench_pin.sim.bodies.urdf import check_urdf
from rlbench_pin.sim.render.egl import RENDERERS, EglMissing, RendererName, plugin_file
from rlbench_pin.sim.server.journal import Journal
from rlbench_pin.sim.server.output import captured_output
from rlbench_pin.spatial import FloatArray

with captured_output():  # pybullet prints a line when it is imported
    import pybullet as bullet

__all__ = ["PASSES", "PhysicsClient", "bullet", "open_client"]

PASSES = 35
"""Most passes over contacts, motors and constraints in one physics step."""
_RESIDUAL = 3e-7
"""Square of the largest change of speed in a pass below which a group of things that touch counts as solved [m^2/s^2]."""
_GRAVITY = (0.0, 0.0, -9.81)  # [m/s^2]


class PhysicsClient:
    """One physics server in this process; every call passes its `id`.

    Calls that change a world while it is built go through `change`, so that `build_again` can repeat them. What moves something
    goes through `change`, `step` or `restore`; calls that only read use `bullet` directly.

    Args:
        timestep: Length of one physics step [s].
        hardware: Draw with OpenGL through EGL.

    Attributes:
        journal: The calls that built the world.
        placements: T_world_link by body and link number, as far as they were read since something last moved.
        changes: How many changes there were, but for those of colours.

    Raises:
        EglMissing: There is no EGL here.
    """

    def __init__(self, timestep: float, hardware: bool = False) -> None:
        self.hardware = hardware
        self._id: int | None = bullet.connect(bullet.DIRECT)
        self.journal = Journal()
        self.placements: dict[tuple[int, int], pin.SE3] = {}
        if hardware:
            self._plugin = self._load_egl()
        self._printed, self._passes, self.changes = False, PASSES, 0
        self.change(bullet.setTimeStep, timestep)
        self.change(bullet.setGravity, *_GRAVITY)
        solver = {"numSolverIterations": PASSES, "solverResidualThreshold": _RESIDUAL}
        self.change(bullet.setPhysicsEngineParameter, **solver, deterministicOverlappingPairs=1)
        for caching in (0, 1):  # forget what files said when an earlier world was built, then read each of them once
            bullet.setPhysicsEngineParameter(enableFileCaching=caching, physicsClientId=self.id)

    def change(self, function: Callable[..., Any], *positional: Any, **named: Any) -> Any:
        """Call a function of PyBullet that changes this world; until `end_building` the call is recorded.

        Args:
            function: A function of `bullet`.
            *positional: Its arguments.
            **named: Its named arguments, without `physicsClientId`.
        """
        self.placements.clear()
        if function is not bullet.changeVisualShape:
            self.changes += 1
        return self.journal.call(function, *positional, **named, physicsClientId=self.id)

    def step(self) -> None:
        """Advance one physics step."""
        self.placements.clear()
        bullet.stepSimulation(physicsClientId=self.id)

    def restore(self, **state: Any) -> None:
        """Go back to a state of this server; takes the arguments of PyBullet's `restoreState`."""
        self.placements.clear()
        bullet.restoreState(**state, physicsClientId=self.id)

    def end_building(self) -> None:
        """Record no more calls: the world is built."""
        self.journal.close()

    def build_again(self) -> None:
        """Empty the server, and repeat all calls recorded until `end_building`.

        Bodies keep their numbers. What was simulated before leaves no trace, not even in the order in which PyBullet looks at
        contacts.

        Raises:
            RlbenchPinError: A call returned something else than the first time; the server is closed then.
        """
        self.placements.clear()
        bullet.resetSimulation(physicsClientId=self.id)
        self._passes = PASSES
        try:
            with captured_output() if self._printed else nullcontext():
                self.journal.repeat()
        except BaseException:
            self.close()
            raise

    def allow_passes(self, passes: int) -> None:
        """Let the solver make so many passes at most in the physics steps to come."""
        if passes != self._passes:
            bullet.setPhysicsEngineParameter(numSolverIterations=passes, physicsClientId=self.id)
            self._passes = passes

    def _load_egl(self) -> int:
        try:
            file = plugin_file()
            with captured_output() as captured:
                plugin = int(bullet.loadPlugin(file, "_eglRendererPlugin", physicsClientId=self.id))
            if plugin < 0:
                raise EglMissing(_tidy(captured.text) or "the plugin found no device")
        except EglMissing:
            self.close()
            raise
        return plugin

    def __reduce__(self) -> NoReturn:
        """Refuse to be pickled or copied: the server lives in this process."""
        raise TypeError("A world belongs to its process. Send `World.arrays()`, or the state that `get_state()` returns.")

    @property
    def id(self) -> int:
        """Number of the connection; raises EnvironmentClosed after `close`."""
        if self._id is None:
            raise EnvironmentClosed("This world is closed. Build a new one.")
        return self._id

    @property
    def closed(self) -> bool:
        """True after `close`."""
        return self._id is None

    def close(self) -> None:
        """Free the physics server; may be called again."""
        self.placements.clear()
        if self._id is not None:
            identifier, self._id = self._id, None
            with captured_output() if self.hardware else nullcontext():
                bullet.disconnect(physicsClientId=identifier)

    def load(self, urdf: Path, needed_by: str, pose: FloatArray, fixed: bool, scale: float = 1.0) -> int:
        """Load a URDF with its base link at `pose` (7,) and return its number.

        Raises:
            AssetNotFound: There is no such file.
            AssetInvalid: PyBullet cannot read it; carries what it printed.
        """
        if not urdf.is_file():
            raise AssetNotFound(urdf, needed_by)
        check_urdf(urdf)
        problem = ""
        with captured_output() as captured:
            try:
                number: int = self.change(
                    bullet.loadURDF,
                    str(urdf),
                    pose[:3].tolist(),
                    pose[3:].tolist(),
                    useFixedBase=fixed,
                    globalScaling=scale,
                    flags=bullet.URDF_USE_INERTIA_FROM_FILE,
                )
            except bullet.error as error:
                problem = str(error)
        self._printed |= bool(captured.text)
        if problem:
            raise AssetInvalid(urdf, f"{problem} {_tidy(captured.text)}".strip())
        return number


def open_client(timestep: float, renderer: RendererName) -> PhysicsClient:
    """Start a physics server that draws as asked.

    Args:
        timestep: Length of one physics step [s].
        renderer: `cpu`, `egl`, or `auto`: EGL where there is one, else the CPU.

    Raises:
        EglMissing: EGL was asked for and there is none.
        UnknownName: There is no such renderer.
    """
    if renderer not in RENDERERS:
        raise UnknownName("renderer", str(renderer), RENDERERS)
    if renderer == "cpu":
        return PhysicsClient(timestep)
    try:
        return PhysicsClient(timestep, hardware=True)
    except EglMissing:
        if renderer == "egl":
            raise
        return PhysicsClient(timestep)


def _tidy(text: str) -> str:
    """Keep the lines of a C message that carry information."""
    lines = (line.strip() for line in text.splitlines())
    return "; ".join(line for line in lines if line and not line.startswith("b3"))[:500]
