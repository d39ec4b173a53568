"""Where each claim is judged, so that one of them does not load the modules of all."""

from __future__ import annotations

__all__ = ["CLAIM_MODULES", "module_of"]

# Modules with a tuple CHECKS each, in the order of the chapter, and the claims in it.
CLAIM_MODULES = {
    "method.stitching_claims": "G1",
    "method.surface_claims": "G2",
    "method.smoothing_claims": "G3",
    "mole.drilling_claims": "M01",
    "mole.soil_claims": "M02",
    "mole.data_claims": "M03 M04",
    "mole.run_claims": "M05 M06 M15 M16",
    "mole.model_claims": "M07 M08 M46",
    "mole.steady_claims": "M09 M10 M11 M12",
    "mole.window_claims": "M13 M18 M19 M20 M21 M22 M23",
    "mole.cascade_claims": "M14",
    "mole.progression_claims": "M17 M24 M25 M26 M27 M28 M29",
    "mole.orbit_claims": "M30 M31 M32 M33",
    "mole.work_claims": "M34",
    "mole.branch_claims": "M35 M36 M37 M38 M39 M40 M41",
    "mole.drift_claims": "M42 M43 M44 M45",
    "mole.basin_claims": "M47 M48 M49 M50 M51 M52 M53 M54",
    "mole.frequency_claims": "M55 M57",
    "mole.best_ratio_claims": "M56",
    "fatigue.specimen_claims": "F01 F02 F03 F04 F05 F20",
    "fatigue.life_claims": "F06 F07 F08 F09 F10 F11 F12",
    "fatigue.chaos_claims": "F13 F14 F15 F16 F17",
    "fatigue.record_claims": "F18 F19",
    "fatigue.rig_model_claims": "F21 F22 F23 F31",
    "fatigue.phase_claims": "F24 F25 F26 F27",
    "fatigue.rig_si_claims": "F28 F29 F30 F32",
    "fatigue.stiffness_claims": "F33 F34 F35 F40 F41",
    "fatigue.portrait_claims": "F36 F37 F38 F39",
    "fatigue.growth_claims": "F42 F43 F44 F58",
    "fatigue.regime_claims": "F45 F46 F47 F48",
    "fatigue.growing_claims": "F49 F50 F51 F52 F53 F54 F55 F56",
    "fatigue.frozen_claims": "F57",
    "fatigue.monitoring_claims": "F59",
    "rotor.rig_data_claims": "R01 R02 R03 R04",
    "rotor.statics_claims": "R05 R06 R07 R08 R09 R10",
    "rotor.contact_claims": "R11 R12 R13 R14",
    "rotor.section_claims": "R15 R27 R28 R30 R31 R32",
    "rotor.bifurcation_claims": "R16 R17 R18 R19 R20 R21 R22 R23 R24 R25 R26 R29",
    "rotor.ring_claims": "R33 R34 R35 R36 R37",
    "rotor.rig_diagram_claims": "R38 R39 R40 R41 R42 R43 R44 R45 R46 R47 R48 R49",
    "rotor.rig_regime_claims": "R50 R51 R52 R53",
    "rotor.preload_claims": "R54 R55 R56 R57",
}


def module_of(claim: str) -> str:
    """Module in which a claim is judged, within ``nonsmooth_chapter``.

    Parameters
    ----------
    claim : str
        Its name.

    Returns
    -------
    str

    Examples
    --------
    >>> module_of("M12")
    'mole.steady_claims'
    """
    return next(name for name, claims in CLAIM_MODULES.items() if claim in claims.split())
