"""Enumerations of PyRep."""

from __future__ import annotations

from enum import Enum


class ObjectType(Enum):
    """Type of a scene object."""

    ALL = -2
    SHAPE = 0
    JOINT = 1
    GRAPH = 2
    CAMERA = 3
    DUMMY = 4
    PROXIMITY_SENSOR = 5
    PATH = 8
    VISION_SENSOR = 9
    MILL = 11
    FORCE_SENSOR = 12
    LIGHT = 13
    MIRROR = 14
    OCTREE = 15


class PrimitiveShape(Enum):
    """Primitive shapes of `Shape.create`."""

    CUBOID = 3
    SPHERE = 4
    CYLINDER = 5
    CONE = 6


class JointType(Enum):
    """Type of a joint."""

    REVOLUTE = 10
    PRISMATIC = 11
    SPHERICAL = 12


class JointMode(Enum):
    """Drive mode of a joint."""

    PASSIVE = 0
    IK = 2
    DEPENDENT = 4
    FORCE = 5


class RenderMode(Enum):
    """Render mode of images: OPENGL3 draws shadows, OPENGL does not, OPENGL_COLOR_CODED encodes handles as colours."""

    OPENGL = 0
    OPENGL_AUXILIARY = 1
    OPENGL_COLOR_CODED = 2
    POV_RAY = 3
    EXTERNAL = 4
    EXTERNAL_WINDOWED = 5
    OPENGL3 = 6
    OPENGL3_WINDOWED = 7


class PerspectiveMode(Enum):
    """Projection of a camera; only PERSPECTIVE is available."""

    ORTHOGRAPHIC = 0
    PERSPECTIVE = 1


class TextureMappingMode(Enum):
    """Mapping of a texture to a shape; all are drawn as planar maps along the axes of the shape."""

    PLANE = 0
    CYLINDER = 1
    SPHERE = 2
    CUBE = 3


class ConfigurationPathAlgorithms(Enum):
    """Names of planning algorithms; the planner of this package uses RRT-Connect for those that it does not have."""

    BiTRRT = "BiTRRT"
    BITstar = "BITstar"
    BKPIECE1 = "BKPIECE1"
    CForest = "CForest"
    EST = "EST"
    FMT = "FMT"
    KPIECE1 = "KPIECE1"
    LazyPRM = "LazyPRM"
    LazyPRMstar = "LazyPRMstar"
    LazyRRT = "LazyRRT"
    LBKPIECE1 = "LBKPIECE1"
    LBTRRT = "LBTRRT"
    PDST = "PDST"
    PRM = "PRM"
    PRMstar = "PRMstar"
    pRRT = "pRRT"
    pSBL = "pSBL"
    RRT = "RRT"
    RRTConnect = "RRTConnect"
    RRTstar = "RRTstar"
    SBL = "SBL"
    SPARS = "SPARS"
    SPARStwo = "SPARStwo"
    STRIDE = "STRIDE"
    TRRT = "TRRT"


class Verbosity(Enum):
    """Verbosity of the simulator; it has no effect."""

    NONE = "none"
    ERRORS = "errors"
    WARNINGS = "warnings"
    LOAD_INFOS = "loadinfos"
    SCRIPT_ERRORS = "scripterrors"
    SCRIPT_WARNINGS = "scriptwarnings"
    SCRIPT_INFOS = "scriptinfos"
    INFOS = "infos"
    DEBUG = "debug"
    TRACE = "trace"
    TRACE_LUA = "tracelua"
    TYRACE_ALL = "traceall"
