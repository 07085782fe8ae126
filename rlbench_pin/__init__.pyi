from . import (
    checking as checking,
)
from . import (
    compat as compat,
)
from . import (
    control as control,
)
from . import (
    datasets as datasets,
)
from . import (
    environment as environment,
)
from . import (
    errors as errors,
)
from . import (
    evaluation as evaluation,
)
from . import (
    gym as gym,
)
from . import (
    observation as observation,
)
from . import (
    planning as planning,
)
from . import (
    recording as recording,
)
from . import (
    robot as robot,
)
from . import (
    scene as scene,
)
from . import (
    sim as sim,
)
from . import (
    spatial as spatial,
)
from . import (
    tasks as tasks,
)
from . import (
    urdf as urdf,
)
from . import (
    values as values,
)
from .environment import (
    ActionMode as ActionMode,
)
from .environment import (
    CameraConfig as CameraConfig,
)
from .environment import (
    Discrete as Discrete,
)
from .environment import (
    EndEffectorPoseViaIK as EndEffectorPoseViaIK,
)
from .environment import (
    EndEffectorPoseViaPlanning as EndEffectorPoseViaPlanning,
)
from .environment import (
    EndEffectorVelocity as EndEffectorVelocity,
)
from .environment import (
    Environment as Environment,
)
from .environment import (
    GripperJointPosition as GripperJointPosition,
)
from .environment import (
    JointPosition as JointPosition,
)
from .environment import (
    JointTorque as JointTorque,
)
from .environment import (
    JointVelocity as JointVelocity,
)
from .environment import (
    MoveArmThenGripper as MoveArmThenGripper,
)
from .environment import (
    ObservationConfig as ObservationConfig,
)
from .environment import (
    RandomizeEvery as RandomizeEvery,
)
from .environment import (
    RelativeFrame as RelativeFrame,
)
from .environment import (
    SafeArm as SafeArm,
)
from .environment import (
    TaskEnvironment as TaskEnvironment,
)
from .environment import (
    VisualRandomizationConfig as VisualRandomizationConfig,
)
from .errors import RlbenchPinError as RlbenchPinError
from .observation import Demo as Demo
from .observation import Observation as Observation
from .tasks import task_class as task_class
from .tasks import task_names as task_names

__version__: str
