"""Claims on the data of the experiment: frequencies of Fig. 5, by arithmetic."""

from __future__ import annotations

from nonsmooth_chapter.judgement import Check, Evidence, Finding, agrees

__all__ = ["CHECKS"]


def _cam_forcing(lobes: int = 2, cam_frequency: float = 7.75) -> Evidence:
    return {"forcing": lobes * cam_frequency, "printed_a": "15.5", "printed_c": "13.2"}


def _judge_cam(evidence: Evidence) -> Finding:
    panels = {
        panel: agrees(evidence["forcing"], evidence[f"printed_{panel}"]) for panel in ("a", "c")
    }
    parts = [
        f"printed {evidence[f'printed_{panel}']} Hz for ({panel})"
        f" {'agrees' if fits else 'does not agree'}"
        for panel, fits in panels.items()
    ]
    return Finding(
        all(panels.values()), f"the cam forces at {evidence['forcing']:g} Hz; {', '.join(parts)}"
    )


def _frequency_scale(
    omega_a: str = "0.11", omega_c: str = "0.10", hertz_a: str = "15.5", hertz_c: str = "13.2"
) -> Evidence:
    frequencies = float(hertz_a) / float(hertz_c)
    return {
        "ratio_of_omegas": float(omega_a) / float(omega_c),
        "ratio_of_frequencies": frequencies,
        "omega_c_from_a": float(omega_a) / frequencies,
        "omega_a_from_c": float(omega_c) * frequencies,
        "printed_a": omega_a,
        "printed_c": omega_c,
    }


def _judge_scale(evidence: Evidence) -> Finding:
    fits = [
        agrees(evidence["omega_c_from_a"], evidence["printed_c"]),
        agrees(evidence["omega_a_from_c"], evidence["printed_a"]),
    ]
    text = (
        f"ratio of omegas {evidence['ratio_of_omegas']:.3f}, of frequencies"
        f" {evidence['ratio_of_frequencies']:.3f}; with one Omega_0 the first omega makes the"
        f" second {evidence['omega_c_from_a']:.4f} (printed {evidence['printed_c']}), the second"
        f" makes the first {evidence['omega_a_from_c']:.4f} (printed {evidence['printed_a']})"
    )
    return Finding(None if fits[0] != fits[1] else fits[0], text)


CHECKS = (
    Check("M03", "arithmetic, one unit of the last printed digit", _cam_forcing, _judge_cam),
    Check(
        "M04",
        "arithmetic with one Omega_0 taken from either panel, one unit of the last printed digit",
        _frequency_scale,
        _judge_scale,
    ),
)
