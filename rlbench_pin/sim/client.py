"""Client of a PyBullet physics server, with a journal of the calls that built its world. Only this module imports pybullet."""

from __future__ import annotations

import ctypes
import gc
import importlib.util
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NoReturn, get_args

import pinocchio as pin

from rlbench_pin.errors import AssetInvalid, AssetNotFound, CameraError, EnvironmentClosed, RlbenchPinError, UnknownName
from rlbench_pin.sim.output import captured_output
from rlbench_pin.spatial import FloatArray
from rlbench_pin.urdf import Urdf, read_urdf


@dataclass(frozen=True)
class Change:
    """One call that changed a physics server, and what it returned."""

    function: Callable[..., Any]
    positional: tuple[Any, ...]
    named: Mapping[str, Any]
    result: Any

    def repeat(self) -> None:
        """Make the call again.

        Raises:
            RlbenchPinError: It failed, or its result differs from the recorded one.
        """
        name = self.function.__name__
        try:
            result = self.function(*self.positional, **self.named)
        except Exception as error:
            problem = f"{name}{self.positional} failed: {error}"
        else:
            if result == self.result:
                return
            problem = f"{name}{self.positional} gave {result} instead of {self.result}"
        raise RlbenchPinError(
            f"The world could not be built again: {problem}. Restore the files it was built from, and load the task again."
        )


class Journal:
    """Journal of calls, in order, until it is closed."""

    def __init__(self) -> None:
        self._changes: list[Change] = []
        self._closed = False

    @property
    def changes(self) -> tuple[Change, ...]:
        """The recorded calls, in order."""
        return tuple(self._changes)

    def call(self, function: Callable[..., Any], *positional: Any, **named: Any) -> Any:
        """Call a function and return its result; the call is recorded unless the journal is closed."""
        result = function(*positional, **named)
        if not self._closed:
            self._changes.append(Change(function, positional, named, result))
        return result

    def close(self) -> None:
        """Stop recording."""
        self._closed = True

    def repeat(self) -> None:
        """Make all recorded calls again.

        Raises:
            RlbenchPinError: A call failed, or its result differs from the recorded one.
        """
        for change in self._changes:
            change.repeat()


_BEGINNING, _MIN_BYTES = b"BULLET", 64
_MEMORY = "/dev/shm"
"""Files there are on no disk, and six times as fast; where it is missing, the system's folder for temporary files is used."""


def to_bytes(client: PhysicsClient) -> bytes:
    """Return the state of a physics server as bytes."""
    with _temporary_file() as file:
        bullet.saveBullet(str(file), physicsClientId=client.id)
        return file.read_bytes()


def restore_bytes(client: PhysicsClient, physics: bytes) -> None:
    """Restore a physics server to a state from `to_bytes`.

    Raises:
        RlbenchPinError: The bytes are damaged, or are of other bodies.
    """
    problem = "The array 'physics' does not fit this world: it has other bodies or is damaged. Use a world with its scene."
    if not physics.startswith(_BEGINNING) or len(physics) < _MIN_BYTES:
        raise RlbenchPinError(problem)
    with _temporary_file() as file:
        file.write_bytes(physics)
        try:
            client.restore(fileName=str(file))
        except bullet.error as error:
            raise RlbenchPinError(problem) from error


@contextmanager
def _temporary_file() -> Iterator[Path]:
    """Yield a path that was never used before, because PyBullet caches files by name."""
    memory = _MEMORY if os.access(_MEMORY, os.W_OK | os.X_OK) else None
    with tempfile.TemporaryDirectory(dir=memory) as folder:
        yield Path(folder) / "state.bullet"


_TRIM = getattr(ctypes.CDLL(None), "malloc_trim", None)
"""Hands free memory back to the system; only glibc has it."""


def give_back_memory(*, collect: bool = False) -> None:
    """Return unused memory to the system.

    The C library keeps the freed memory of a physics server, some 30 MB for each closed world, until this call.

    Args:
        collect: Run Python's garbage collection first.
    """
    if collect:
        gc.collect()
    if _TRIM is not None:
        _TRIM(0)


def check_urdf(file: Path) -> None:
    """Check that links and joints form one tree and all meshes exist, because PyBullet ends the process on some broken files.

    Raises:
        AssetNotFound: A mesh does not exist.
        AssetInvalid: The file is not XML, or its joints do not connect its links to one tree.
    """
    urdf = read_urdf(file)
    links = urdf.link_names
    if not links or len(set(links)) < len(links):
        raise AssetInvalid(file, "it has no link" if not links else "two links have the same name")
    _check_joints(urdf, links)
    for mesh in urdf.meshes:
        if not mesh.is_file():
            raise AssetNotFound(mesh, file.name)


def _check_joints(urdf: Urdf, links: tuple[str, ...]) -> None:
    parents: dict[str, str] = {}
    for joint in urdf.joints:
        for link in (joint.parent, joint.child):
            if link not in links:
                raise AssetInvalid(urdf.path, f"joint '{joint.name}' names the link '{link}', which does not exist")
        if joint.child in parents:
            raise AssetInvalid(urdf.path, f"the link '{joint.child}' is the child of two joints")
        parents[joint.child] = joint.parent
    roots = [link for link in links if link not in parents]
    if len(roots) != 1:
        raise AssetInvalid(urdf.path, f"it needs one link that is not the child of a joint, but has {', '.join(roots) or 'none'}")
    for link in links:
        if not _reaches(link, roots[0], parents):
            raise AssetInvalid(urdf.path, f"the link '{link}' is not connected to '{roots[0]}'")


def _reaches(link: str, root: str, parents: dict[str, str]) -> bool:
    for _ in range(len(parents) + 1):
        if link == root:
            return True
        link = parents.get(link, root)
    return False


RendererName = Literal["cpu", "egl", "auto"]
RENDERERS: tuple[str, ...] = get_args(RendererName)
_HINT = "Use renderer='cpu', or renderer='auto' to fall back by itself; `rlbench-pin doctor` shows what works here."


class EglMissing(CameraError):
    """EGL was requested, but is not available."""

    def __init__(self, cause: str) -> None:
        self.cause = cause
        super().__init__(f"The EGL renderer cannot be used: {cause}. {_HINT}")


def plugin_file() -> str:
    """Return the file of the EGL plugin.

    Raises:
        EglMissing: This PyBullet does not include the plugin.
    """
    spec = importlib.util.find_spec("eglRenderer")
    if spec is None or spec.origin is None:
        raise EglMissing("this PyBullet has no eglRenderer plugin")
    return spec.origin


with captured_output():  # pybullet prints a line when it is imported
    import pybullet as bullet


PASSES = 35
"""Most passes over contacts, motors and constraints in one physics step."""
_RESIDUAL = 3e-7
"""Square of the largest change of speed in a pass below which a group of objects that touch counts as solved [m^2/s^2]."""
_GRAVITY = (0.0, 0.0, -9.81)  # [m/s^2]


class PhysicsClient:
    """One physics server in this process; every call passes its `id`.

    Calls that build a world use `change`, so that `build_again` can repeat them. Calls that change the world use `change`, `step`
    or `restore`; calls that only read use `bullet` directly.

    Args:
        timestep: Length of one physics step [s].
        hardware: Draw with OpenGL through EGL.
        server: Number of the server that another client has left, which keeps what it has read from files; None starts one.

    Attributes:
        journal: The calls that built the world.
        placements: T_world_link by body and link number, for links that were read since the last change.
        changes: Number of changes, without changes of colours.

    Raises:
        EglMissing: EGL is not available.
    """

    def __init__(self, timestep: float, hardware: bool = False, server: int | None = None) -> None:
        self.hardware = hardware
        self._id: int | None = bullet.connect(bullet.DIRECT) if server is None else server
        self.journal = Journal()
        self.placements: dict[tuple[int, int], pin.SE3] = {}
        if hardware:
            self._load_egl()
        self._printed, self._passes, self.changes = False, PASSES, 0
        self.change(bullet.setTimeStep, timestep)
        self.change(bullet.setGravity, *_GRAVITY)
        solver = {"numSolverIterations": PASSES, "solverResidualThreshold": _RESIDUAL}
        self.change(bullet.setPhysicsEngineParameter, **solver, deterministicOverlappingPairs=1)
        for caching in (0, 1) if server is None else ():  # forget files that an earlier world read, then read each once
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
        """Restore a state of this server; the arguments are those of PyBullet's `restoreState`."""
        self.placements.clear()
        bullet.restoreState(**state, physicsClientId=self.id)

    def end_building(self) -> None:
        """Stop recording calls, because the world is built."""
        self.journal.close()

    def build_again(self) -> None:
        """Empty the server, and repeat all calls recorded until `end_building`.

        Bodies keep their numbers. The earlier simulation has no influence any more, not even on the order of PyBullet's contacts.

        Raises:
            RlbenchPinError: The result of a call differs from the recorded one; the server is then closed.
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

    def leave(self) -> int:
        """Empty the server and return its number; this client is closed then."""
        self.placements.clear()
        left, self._id = self.id, None
        bullet.resetSimulation(physicsClientId=left)
        return left

    def allow_passes(self, passes: int) -> None:
        """Set the largest number of solver iterations in the next physics steps."""
        if passes != self._passes:
            bullet.setPhysicsEngineParameter(numSolverIterations=passes, physicsClientId=self.id)
            self._passes = passes

    def _load_egl(self) -> None:
        try:
            file = plugin_file()
            with captured_output() as captured:
                number = bullet.loadPlugin(file, "_eglRendererPlugin", physicsClientId=self.id)
            if number < 0:
                raise EglMissing(_tidy(captured.text) or "the plugin found no device")
        except EglMissing:
            self.close()
            raise

    def __reduce__(self) -> NoReturn:
        """Refuse to be pickled or copied, because the server belongs to this process."""
        raise TypeError("A world belongs to its process. Send `World.arrays()`, or the state that `get_state()` returns.")

    @property
    def id(self) -> int:
        """Number of the connection; raise EnvironmentClosed after `close`."""
        if self._id is None:
            raise EnvironmentClosed("This world is closed. Build a new one.")
        return self._id

    @property
    def closed(self) -> bool:
        """True after `close`."""
        return self._id is None

    def close(self) -> None:
        """Free the physics server; repeated calls have no effect."""
        self.placements.clear()
        if self._id is not None:
            identifier, self._id = self._id, None
            with captured_output() if self.hardware else nullcontext():
                bullet.disconnect(physicsClientId=identifier)

    def load(self, urdf: Path, needed_by: str, pose: FloatArray, fixed: bool, scale: float = 1.0) -> int:
        """Load a URDF with its base link at `pose` (7,) and return its number.

        Raises:
            AssetNotFound: The file does not exist.
            AssetInvalid: PyBullet cannot read it; the message includes PyBullet's output.
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
    """Start a physics server with a renderer.

    Args:
        timestep: Length of one physics step [s].
        renderer: `cpu`, `egl`, or `auto`: EGL if it is available, else the CPU.

    Raises:
        EglMissing: EGL was requested, but is not available.
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
