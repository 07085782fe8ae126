"""Errors of PyRep; all are errors of rlbench_pin as well."""

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
    """The object with a name has another type."""


class ObjectAlreadyRemovedError(PyRepError):
    """An object was used after `remove()`."""


class ObjectIsNotModelError(PyRepError):
    """A method for models was called on an object that is no model."""


class GripperError(PyRepError):
    """The gripper cannot execute a request."""


class ConfigurationError(PyRepError):
    """No joint configuration of the arm meets the requirements."""


class ConfigurationPathError(PyRepError):
    """No path of the arm was found."""


class IKError(PyRepError):
    """No joint configuration reaches a pose."""
