"""Errors that users of scene objects catch; all are errors of this package as well."""

from __future__ import annotations

from rlbench_pin.compat.objects import UnknownObject, UnsupportedCall
from rlbench_pin.errors import RlbenchPinError

__all__ = [
    "ConfigurationError",
    "ConfigurationPathError",
    "GripperError",
    "IKError",
    "ObjectAlreadyRemovedError",
    "ObjectIsNotModelError",
    "PyRepError",
    "UnknownObject",
    "UnsupportedCall",
    "WrongObjectTypeError",
]


class PyRepError(RlbenchPinError):
    """Base class of the errors of this package."""


class WrongObjectTypeError(PyRepError):
    """A name belongs to an object of another type."""


class ObjectAlreadyRemovedError(PyRepError):
    """An object was used after `remove()`."""


class ObjectIsNotModelError(PyRepError):
    """A call for models was made on another object."""


class GripperError(PyRepError):
    """The gripper cannot execute a request."""


class ConfigurationError(PyRepError):
    """No joint configuration of the arm fulfils a request."""


class ConfigurationPathError(PyRepError):
    """No path of the arm was found."""


class IKError(PyRepError):
    """No joint configuration reaches a pose."""
