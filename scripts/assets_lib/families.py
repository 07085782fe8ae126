"""The list of all objects: one module of `objects/` per family, detected automatically."""

from __future__ import annotations

import importlib
import pkgutil

from assets_lib import objects
from assets_lib.urdf import Model


def family_names() -> tuple[str, ...]:
    """Return the names of all families, in the order of the catalogue."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(objects.__path__)))


def models_of(family: str) -> tuple[Model, ...]:
    """Return the objects of one family."""
    return tuple(importlib.import_module(f"assets_lib.objects.{family}").models())


def all_models() -> tuple[Model, ...]:
    """Return every object, in the order of the catalogue."""
    return tuple(model for family in family_names() for model in models_of(family))
