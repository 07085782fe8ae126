"""Factors of generalisation: named, graded changes of an episode, over every task."""

from rlbench_pin.environment.factors.catalogue import Factor, FactorSetting, FactorsLike, Level, expand_settings, factor_catalogue
from rlbench_pin.environment.factors.randomizer import FactorNotApplicable, FactorRandomizer

__all__ = [
    "Factor",
    "FactorNotApplicable",
    "FactorRandomizer",
    "FactorSetting",
    "FactorsLike",
    "Level",
    "expand_settings",
    "factor_catalogue",
]
