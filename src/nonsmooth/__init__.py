"""Exact simulation and analysis of piecewise-smooth dynamical systems.

Names are imported when first used, so that ``import nonsmooth`` costs nothing.
"""

from __future__ import annotations

import importlib
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any

from nonsmooth.version import __version__

if TYPE_CHECKING:
    from nonsmooth import (
        cluster,
        continuation,
        excitation,
        fatigue,
        measured,
        models,
        plot,
        structures,
    )
    from nonsmooth.analysis.attractors import attractors
    from nonsmooth.analysis.basin_entropy import basin_entropy
    from nonsmooth.analysis.basin_fractions import basin_fractions
    from nonsmooth.analysis.basins_of_attraction import basins_of_attraction
    from nonsmooth.analysis.best_point import best_point
    from nonsmooth.analysis.bifurcation_diagram import bifurcation_diagram
    from nonsmooth.analysis.bifurcation_picture import bifurcation_picture
    from nonsmooth.analysis.box_dimension import box_dimension
    from nonsmooth.analysis.contact_statistics import contact_statistics
    from nonsmooth.analysis.continue_orbit import continue_orbit
    from nonsmooth.analysis.continue_special import continue_special
    from nonsmooth.analysis.correlation_dimension import correlation_dimension
    from nonsmooth.analysis.criticality import criticality
    from nonsmooth.analysis.edge_state import edge_state
    from nonsmooth.analysis.ensemble import ensemble
    from nonsmooth.analysis.erosion_profile import erosion_profile
    from nonsmooth.analysis.find_orbit import find_orbit
    from nonsmooth.analysis.full_spectrum import full_spectrum
    from nonsmooth.analysis.homoclinic_points import homoclinic_points
    from nonsmooth.analysis.homoclinic_tangency import homoclinic_tangency
    from nonsmooth.analysis.integrity import integrity
    from nonsmooth.analysis.local_regimes import local_regimes
    from nonsmooth.analysis.lyapunov_spectrum import lyapunov_spectrum
    from nonsmooth.analysis.manifold import manifold
    from nonsmooth.analysis.mirrored_orbit import mirrored_orbit
    from nonsmooth.analysis.orbit_samples import orbit_samples
    from nonsmooth.analysis.orbits import orbits
    from nonsmooth.analysis.order_tracking import order_tracking
    from nonsmooth.analysis.period_statistics import period_statistics
    from nonsmooth.analysis.poincare_section import poincare_section
    from nonsmooth.analysis.power_spectrum import power_spectrum
    from nonsmooth.analysis.regime import regime
    from nonsmooth.analysis.regime_map import regime_map
    from nonsmooth.analysis.return_map import return_map
    from nonsmooth.analysis.smoothing_report import smoothing_report
    from nonsmooth.analysis.stroboscopic_map import stroboscopic_map
    from nonsmooth.analysis.tie_parameters import tie_parameters
    from nonsmooth.analysis.uncertainty_exponent import uncertainty_exponent
    from nonsmooth.analysis.wada_test import wada_test
    from nonsmooth.analysis.waterfall import waterfall
    from nonsmooth.analysis.zero_one_test import zero_one_test
    from nonsmooth.errors import (
        ModelError,
        NonsmoothError,
        OptionError,
        ResultWarning,
        RunError,
        RunWarning,
    )
    from nonsmooth.explorer.explore import explore
    from nonsmooth.fitting.fit import fit
    from nonsmooth.fitting.posterior import posterior
    from nonsmooth.runs.devices import use_device
    from nonsmooth.runs.poincare_map import PoincareMap
    from nonsmooth.runs.simulate import simulate
    from nonsmooth.runs.stroboscopic_map import StroboscopicMap
    from nonsmooth.runs.words import phase_word
    from nonsmooth.structures.structure import Structure
    from nonsmooth.system.parts import Exit, Mode
    from nonsmooth.system.signals import Signal
    from nonsmooth.system.smoothed import smoothed
    from nonsmooth.system.surfaces import Surface
    from nonsmooth.system.system import System

__all__ = [
    "Exit",
    "Mode",
    "ModelError",
    "NonsmoothError",
    "OptionError",
    "PoincareMap",
    "ResultWarning",
    "RunError",
    "RunWarning",
    "Signal",
    "StroboscopicMap",
    "Structure",
    "Surface",
    "System",
    "__version__",
    "attractors",
    "basin_entropy",
    "basin_fractions",
    "basins_of_attraction",
    "best_point",
    "bifurcation_diagram",
    "bifurcation_picture",
    "box_dimension",
    "cluster",
    "contact_statistics",
    "continuation",
    "continue_orbit",
    "continue_special",
    "correlation_dimension",
    "criticality",
    "edge_state",
    "ensemble",
    "erosion_profile",
    "excitation",
    "explore",
    "fatigue",
    "find_orbit",
    "fit",
    "full_spectrum",
    "homoclinic_points",
    "homoclinic_tangency",
    "integrity",
    "local_regimes",
    "lyapunov_spectrum",
    "manifold",
    "measured",
    "mirrored_orbit",
    "models",
    "orbit_samples",
    "orbits",
    "order_tracking",
    "period_statistics",
    "phase_word",
    "plot",
    "poincare_section",
    "posterior",
    "power_spectrum",
    "regime",
    "regime_map",
    "return_map",
    "simulate",
    "smoothed",
    "smoothing_report",
    "stroboscopic_map",
    "structures",
    "tie_parameters",
    "uncertainty_exponent",
    "use_device",
    "wada_test",
    "waterfall",
    "zero_one_test",
]

_MODULES = (
    "cluster",
    "continuation",
    "excitation",
    "fatigue",
    "measured",
    "models",
    "plot",
    "structures",
)
_HOME = {
    "Exit": "nonsmooth.system.parts",
    "Mode": "nonsmooth.system.parts",
    "ModelError": "nonsmooth.errors",
    "NonsmoothError": "nonsmooth.errors",
    "OptionError": "nonsmooth.errors",
    "PoincareMap": "nonsmooth.runs.poincare_map",
    "ResultWarning": "nonsmooth.errors",
    "RunError": "nonsmooth.errors",
    "RunWarning": "nonsmooth.errors",
    "Signal": "nonsmooth.system.signals",
    "StroboscopicMap": "nonsmooth.runs.stroboscopic_map",
    "Structure": "nonsmooth.structures.structure",
    "Surface": "nonsmooth.system.surfaces",
    "System": "nonsmooth.system.system",
    "attractors": "nonsmooth.analysis.attractors",
    "basin_entropy": "nonsmooth.analysis.basin_entropy",
    "basin_fractions": "nonsmooth.analysis.basin_fractions",
    "basins_of_attraction": "nonsmooth.analysis.basins_of_attraction",
    "best_point": "nonsmooth.analysis.best_point",
    "bifurcation_diagram": "nonsmooth.analysis.bifurcation_diagram",
    "bifurcation_picture": "nonsmooth.analysis.bifurcation_picture",
    "box_dimension": "nonsmooth.analysis.box_dimension",
    "contact_statistics": "nonsmooth.analysis.contact_statistics",
    "correlation_dimension": "nonsmooth.analysis.correlation_dimension",
    "edge_state": "nonsmooth.analysis.edge_state",
    "ensemble": "nonsmooth.analysis.ensemble",
    "erosion_profile": "nonsmooth.analysis.erosion_profile",
    "explore": "nonsmooth.explorer.explore",
    "find_orbit": "nonsmooth.analysis.find_orbit",
    "fit": "nonsmooth.fitting.fit",
    "continue_orbit": "nonsmooth.analysis.continue_orbit",
    "manifold": "nonsmooth.analysis.manifold",
    "mirrored_orbit": "nonsmooth.analysis.mirrored_orbit",
    "orbit_samples": "nonsmooth.analysis.orbit_samples",
    "continue_special": "nonsmooth.analysis.continue_special",
    "criticality": "nonsmooth.analysis.criticality",
    "full_spectrum": "nonsmooth.analysis.full_spectrum",
    "homoclinic_points": "nonsmooth.analysis.homoclinic_points",
    "homoclinic_tangency": "nonsmooth.analysis.homoclinic_tangency",
    "integrity": "nonsmooth.analysis.integrity",
    "local_regimes": "nonsmooth.analysis.local_regimes",
    "lyapunov_spectrum": "nonsmooth.analysis.lyapunov_spectrum",
    "orbits": "nonsmooth.analysis.orbits",
    "order_tracking": "nonsmooth.analysis.order_tracking",
    "period_statistics": "nonsmooth.analysis.period_statistics",
    "phase_word": "nonsmooth.runs.words",
    "posterior": "nonsmooth.fitting.posterior",
    "poincare_section": "nonsmooth.analysis.poincare_section",
    "power_spectrum": "nonsmooth.analysis.power_spectrum",
    "regime": "nonsmooth.analysis.regime",
    "regime_map": "nonsmooth.analysis.regime_map",
    "return_map": "nonsmooth.analysis.return_map",
    "simulate": "nonsmooth.runs.simulate",
    "smoothed": "nonsmooth.system.smoothed",
    "smoothing_report": "nonsmooth.analysis.smoothing_report",
    "stroboscopic_map": "nonsmooth.analysis.stroboscopic_map",
    "tie_parameters": "nonsmooth.analysis.tie_parameters",
    "uncertainty_exponent": "nonsmooth.analysis.uncertainty_exponent",
    "use_device": "nonsmooth.runs.devices",
    "wada_test": "nonsmooth.analysis.wada_test",
    "waterfall": "nonsmooth.analysis.waterfall",
    "zero_one_test": "nonsmooth.analysis.zero_one_test",
}


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return importlib.import_module(f"nonsmooth.{name}")
    if name not in _HOME:
        near = get_close_matches(name, __all__, n=1)
        hint = f"; did you mean {near[0]!r}?" if near else ""
        raise AttributeError(f"module 'nonsmooth' has no attribute {name!r}{hint}")
    value = getattr(importlib.import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
