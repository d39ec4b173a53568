"""Pictures of results: a dataset and axes in, axes out.

Nothing is simulated here, but for the motion between the samples of a run that a film shows.

matplotlib is imported when something is drawn.
"""

from __future__ import annotations

from nonsmooth.drawings import Drawing, drawing_of
from nonsmooth.plot.alarms import alarm, roc
from nonsmooth.plot.animation import animate
from nonsmooth.plot.basins import attractors, basins
from nonsmooth.plot.bode import frequency_response, unbalance_response
from nonsmooth.plot.branches import branch
from nonsmooth.plot.campbell_diagram import campbell
from nonsmooth.plot.cascades import waterfall
from nonsmooth.plot.compared_lives import lives
from nonsmooth.plot.comparisons import comparison
from nonsmooth.plot.deflections import mode_shapes
from nonsmooth.plot.diagrams import bifurcation
from nonsmooth.plot.edges import edge_state
from nonsmooth.plot.eigenvalue_paths import root_locus
from nonsmooth.plot.erosion import erosion_profile
from nonsmooth.plot.exponents import exponents, translation
from nonsmooth.plot.figures import print_figure, save_figure
from nonsmooth.plot.film_files import save_animation
from nonsmooth.plot.fitted_records import fit
from nonsmooth.plot.fitted_spectra import fit_spectra
from nonsmooth.plot.fracture import crack_lengths, stiffness_laws, stress_intensity
from nonsmooth.plot.growth_curves import growth_curve
from nonsmooth.plot.histories import phases, time_history
from nonsmooth.plot.homoclinic import homoclinic_points
from nonsmooth.plot.legends import place_legend
from nonsmooth.plot.likelihood_profiles import profiles
from nonsmooth.plot.load_cycles import load_cycles
from nonsmooth.plot.manifolds import manifold
from nonsmooth.plot.markers import event_markers
from nonsmooth.plot.multipliers import multipliers
from nonsmooth.plot.orbits import orbit
from nonsmooth.plot.parameter_pairs import corner
from nonsmooth.plot.periodic_orbits import orbit_history, periodic_orbit
from nonsmooth.plot.pictures import bifurcation_picture
from nonsmooth.plot.portrait import phase_portrait
from nonsmooth.plot.portrait_stack import phase_portrait_3d
from nonsmooth.plot.record_quality import quality
from nonsmooth.plot.reduced_models import reduction
from nonsmooth.plot.regimes import regime_map
from nonsmooth.plot.return_maps import cobweb, return_map
from nonsmooth.plot.ring_regions import contact_regions
from nonsmooth.plot.sections import section
from nonsmooth.plot.shaking import shaking
from nonsmooth.plot.smoothing_ladder import smoothing
from nonsmooth.plot.spectrum import spectrum
from nonsmooth.plot.statistic_curves import statistics
from nonsmooth.plot.style import PALETTE, axis_label, mode_colours
from nonsmooth.plot.transient_points import transient_section
from nonsmooth.plot.uncertainty_curve import uncertainty

__all__ = [
    "PALETTE",
    "Drawing",
    "alarm",
    "animate",
    "attractors",
    "axis_label",
    "basins",
    "bifurcation",
    "bifurcation_picture",
    "branch",
    "campbell",
    "cobweb",
    "comparison",
    "contact_regions",
    "corner",
    "crack_lengths",
    "drawing_of",
    "edge_state",
    "erosion_profile",
    "event_markers",
    "exponents",
    "fit",
    "fit_spectra",
    "frequency_response",
    "growth_curve",
    "homoclinic_points",
    "lives",
    "load_cycles",
    "manifold",
    "mode_colours",
    "mode_shapes",
    "multipliers",
    "orbit",
    "orbit_history",
    "periodic_orbit",
    "phase_portrait",
    "phase_portrait_3d",
    "phases",
    "place_legend",
    "print_figure",
    "profiles",
    "quality",
    "reduction",
    "regime_map",
    "return_map",
    "roc",
    "root_locus",
    "save_animation",
    "save_figure",
    "section",
    "shaking",
    "smoothing",
    "spectrum",
    "statistics",
    "stiffness_laws",
    "stress_intensity",
    "time_history",
    "transient_section",
    "translation",
    "unbalance_response",
    "uncertainty",
    "waterfall",
]


def __dir__() -> list[str]:
    return sorted(__all__)
