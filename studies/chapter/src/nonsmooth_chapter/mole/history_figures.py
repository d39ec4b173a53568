"""Figures of single motions of the mole: the slider, the soil, histories, and phases."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from matplotlib.patches import Rectangle

from nonsmooth import phase_word, simulate
from nonsmooth.models import moling, percussive_drilling
from nonsmooth.plot import PALETTE, phases, place_legend, print_figure, time_history
from nonsmooth_chapter.mole.model_claims import pushed_slider

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["fig2a", "fig3b", "fig5b", "fig5d", "fig6", "fig7", "fig11", "period_one_phases"]


# The simplest progressive system, a mass on a dry-friction slider: Fig. 2(a).

_TEXT = 8
_PERIODS = 4
_NAMES = {"x": "mass, x", "v": "slider, v"}


def fig2a(a: float = 0.3, b: float = 0.15, omega: float = 0.1) -> tuple[Figure, xr.Dataset]:
    """Fig. 2(a): the model, and its motion from rest.

    Parameters
    ----------
    a, b : float, optional
        Amplitude of the harmonic force and static force over the friction limit; the chapter
        prints none for this model, these are the mole's of Fig. 7(d).
    omega : float, optional
        Frequency, which only sets the scales.

    Returns
    -------
    figure : matplotlib.figure.Figure
        The physical model, and displacements of mass and slider over time with the phases of the
        motion below.
    data : xarray.Dataset
        The run from rest, with its event log.

    Examples
    --------
    >>> figure, data = fig2a()
    >>> data.attrs["phase_word"]
    'flight progression stick flight'
    """
    run = simulate(percussive_drilling(a=a, b=b, omega=omega), periods=_PERIODS)
    figure, (model, history) = print_figure(1, 2, width=16.0, height=7.5)
    _model(model)
    phases(run, ["x", "v"], ax=history, labels=_NAMES, legend=False)
    history.set_xlabel(r"time, $\tau$")
    history.set_ylabel("displacement over $P_f/(m\\Omega_0^2)$")
    model.set_title("(a) model", loc="left", fontsize=_TEXT)
    history.set_title("(b) motion from rest", loc="left", fontsize=_TEXT)
    place_legend(history)
    run.attrs["note"] = f"a = {a:g}, b = {b:g}, omega = {omega:g}; the chapter prints none"
    return figure, run


def _model(ax: Axes) -> None:
    """Mass under its force, above a slider that two walls hold by dry friction."""
    grey, force = "0.85", PALETTE["vermilion"]
    ax.add_patch(Rectangle((-0.8, 1.2), 1.6, 1.0, facecolor=grey, edgecolor="black"))
    ax.text(0.0, 1.7, "m", ha="center", va="center", fontsize=_TEXT + 2)
    ax.add_patch(Rectangle((-0.45, -0.75), 0.9, 1.5, facecolor="white", edgecolor="black"))
    ax.plot([-0.8, 0.8], [0.75, 0.75], color="black", linewidth=2.5)
    for side in (-1, 1):
        ax.add_patch(
            Rectangle((side * 0.75 - 0.3, -1.1), 0.6, 1.4, facecolor="none", hatch="////",
                      edgecolor="0.6", linewidth=0.0)
        )  # fmt: skip
        ax.plot([0.45 * side, 0.45 * side], [-1.1, 0.3], color="black", linewidth=1.5)
    _arrow(ax, (0.0, 3.2), (0.0, 2.25), force)
    ax.text(0.15, 2.85, r"$P_s + P_d\cos(\Omega t)$", fontsize=_TEXT, color=force)
    _arrow(ax, (1.35, 2.2), (1.35, 1.3), "black")
    ax.text(1.45, 1.7, "x", fontsize=_TEXT)
    _arrow(ax, (1.35, 0.75), (1.35, -0.15), "black")
    ax.text(1.45, 0.25, "v", fontsize=_TEXT)
    ax.annotate(
        "$P_f$, dry friction", (-0.45, -0.4), (-2.1, -1.55), fontsize=_TEXT,
        arrowprops={"arrowstyle": "-", "linewidth": 0.7},
    )  # fmt: skip
    ax.set_xlim(-2.2, 2.4)
    ax.set_ylim(-1.8, 3.4)
    ax.set_aspect("equal")
    ax.axis("off")


def _arrow(ax: Axes, tail: tuple[float, float], head: tuple[float, float], colour: str) -> None:
    ax.annotate("", head, tail, arrowprops={"arrowstyle": "-|>", "color": colour})


# Resistance of the soil over the penetration of a tool: Fig. 3(b).
#
# The chapter draws it without numbers. Here it is that of the slider that the chapter describes, in
# units of the friction limit, pushed in and drawn back by a prescribed displacement, and under the
# mole itself.

_SLOW, _RATES = 1e-4, (1.0, 4.0)
_DEPTH = 2.5
_SAMPLES = 2000
_SETTLED = 40  # periods; the motion of Fig. 7(d) settles to rounding within twenty
_LOOKS: tuple[dict[str, Any], ...] = (
    {"color": "black", "linewidth": 1.6},
    {"color": PALETTE["blue"], "linewidth": 1.1},
    {"color": PALETTE["vermilion"], "linewidth": 1.1, "linestyle": "-."},
)
_MOLE: dict[str, Any] = {"color": "#7A2060", "linewidth": 1.6}
_LAW: dict[str, Any] = {"color": "0.6", "linewidth": 3.2, "linestyle": (0, (2, 1))}


def fig3b(xi: float = 0.05, b: float = 0.15) -> tuple[Figure, xr.Dataset]:
    """Fig. 3(b): resistance of the slider over penetration, quasi-static and dynamic.

    Parameters
    ----------
    xi : float, optional
        Damping of the slider; the chapter prints none for this figure, that of Fig. 7 is taken.
    b : float, optional
        Static force on the mole of the right panel; a = 0.3 and omega = 0.1 as in Fig. 7.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Pushes of prescribed displacement, in and back: slow, and fast enough for the damper to be
        felt; one impact of the mole in its settled motion, its beginning and its end. Broken: the
        elasto-plastic law without damper, min(penetration, 1) on the way in.
    data : xarray.Dataset
        ``penetration`` and ``resistance`` over ``rate`` and ``sample``; ``mole_penetration`` and
        ``mole_resistance`` over ``mole_sample``.

    Examples
    --------
    >>> figure, data = fig3b()
    >>> float(data["resistance"].max()), round(float(data["mole_resistance"].max()), 12)
    (1.0, 1.0)
    """
    rates = (_SLOW, *_RATES)
    pushes = [
        simulate(pushed_slider(xi, rate, _DEPTH), periods=1, samples_per_period=_SAMPLES)
        for rate in rates
    ]
    impact = _impact(xi, b)
    figure, axes = print_figure(1, 3, width=16.0, height=7.5)
    deepest = float(impact["penetration"].max())
    _draw_law(axes[0], _DEPTH)
    for rate, run, look in zip(rates, pushes, _LOOKS, strict=True):
        name = "quasi-static push" if rate == _SLOW else f"push at rate {rate:g}"
        axes[0].plot(run["penetration"], run["resistance"], label=name, **look)
    for ax in axes[1:]:
        _draw_law(ax, deepest)
        ax.plot(impact["penetration"], impact["resistance"], label="mole", **_MOLE)
    axes[1].set_xlim(-0.05, 1.75)
    axes[2].set_xlim(deepest - 1.75, deepest + 0.05)
    titles = (f"(a) push of depth {_DEPTH:g}, and back", f"(b) mole, b = {b:g}: its impact",
              "(c) mole: its release")  # fmt: skip
    for ax, title in zip(axes, titles, strict=True):
        ax.set_title(title, loc="left", fontsize=_TEXT)
        ax.set_xlabel("penetration [$P_f/k$]")
        ax.set_ylabel("resistance [$P_f$]" if ax is axes[0] else "")
        ax.set_ylim(-0.05, 1.1)
    lines = [*axes[0].get_lines(), axes[1].get_lines()[-1]]
    figure.legend(handles=lines, loc="outside upper center", ncols=5, frameon=False, fontsize=7,
                  columnspacing=1.2)  # fmt: skip
    return figure, _dataset(xi, b, rates, pushes, impact)


def _impact(xi: float, b: float) -> xr.Dataset:
    """Resistance over penetration from one impact of the settled mole to its release."""
    system = moling(b=b, xi=xi)
    settled = simulate(system, simulate(system, periods=_SETTLED), periods=2)
    names = settled["event_name"].values
    hits = settled["event_time"].values[names == "impact"]
    leaves = settled["event_time"].values[settled["event_to"].values == 0]
    began = float(hits[0])
    ended = float(leaves[leaves > began][0])
    times = np.linspace(began, ended, _SAMPLES + 1)
    # samples stand closer where contact begins, for the resistance rises in a twentieth of it
    near = began + (ended - began) * np.geomspace(1e-6, 0.1, _SAMPLES)
    start = simulate(system, periods=_SETTLED)
    run = simulate(system, start, times=np.unique(np.concatenate([times, near, [began - 1.0]])))
    depth = run["x"].values - float(run["x"].sel(time=began, method="nearest"))
    touching = run["mode"].values != 0
    force = np.where(
        touching, np.minimum(2.0 * xi * run["y"].values + run["q"].values, 1.0), 0.0
    )  # in progression the slider slips at its limit
    # at the instant of the impact the resistance jumps to what the damper takes
    depth[0], force[0] = 0.0, 0.0
    return xr.Dataset(
        {"penetration": ("sample", depth), "resistance": ("sample", force)},
        attrs={"status": settled.attrs["status"]},
    )


def _draw_law(ax: Axes, depth: float) -> None:
    """Elasto-plastic law: elastic up to the friction limit, slip, elastic on the way back."""
    ax.plot(
        [0.0, 1.0, depth, depth - 1.0], [0.0, 1.0, 1.0, 0.0], label="law without damper", **_LAW
    )


def _dataset(
    xi: float, b: float, rates: tuple[float, ...], pushes: list[xr.Dataset], impact: xr.Dataset
) -> xr.Dataset:
    over = ("rate", "sample")
    depth = {"long_name": "penetration of the tool", "units": "P_f/k"}
    force = {"long_name": "resistance of the slider", "units": "P_f"}
    return xr.Dataset(
        {
            "penetration": (over, np.stack([run["penetration"].values for run in pushes]), depth),
            "resistance": (over, np.stack([run["resistance"].values for run in pushes]), force),
            "mole_penetration": ("mole_sample", impact["penetration"].values, depth),
            "mole_resistance": ("mole_sample", impact["resistance"].values, force),
        },
        {"rate": ("rate", list(rates), {"long_name": "angular frequency of the push"})},
        {
            "xi": xi, "b": b, "depth": _DEPTH, "status": impact.attrs["status"],
            "note": "the chapter draws this figure without numbers",
            "nonsmooth_version": pushes[0].attrs["nonsmooth_version"],
        },
    )  # fmt: skip


# Histories of the mole: Figs. 5(b), 5(d), 6 and 7.
#
# The chapter prints the parameters; the spans of Figs. 5 and 6 are ours, and all runs start
# from rest.

_FORCES = (0.05, 0.095, 0.1, 0.15, 0.19, 0.27)
_KEPT = ["p", "y", "q", "v", "x", "z", "mode"]
_ATTRIBUTES = ("system_name", "nonsmooth_version", "period", "tolerance")
_LABELS = {"x": "mass, x", "v": "slider bottom, v"}
_TIME, _DISPLACEMENT = r"time, $\tau$", "displacement"


def fig5b() -> tuple[Figure, xr.Dataset]:
    """Fig. 5(b): a = 0.5, omega = 0.11, xi = 0.35, b = 0.456.

    Returns
    -------
    figure : matplotlib.figure.Figure
        The first ten periods from rest.
    data : xarray.Dataset
        The run.

    Examples
    --------
    >>> figure, data = fig5b()
    >>> data.attrs["status"]
    'completed'
    """
    return _test_history(b=0.456, xi=0.35, omega=0.11)


def fig5d() -> tuple[Figure, xr.Dataset]:
    """Fig. 5(d): a = 0.5, omega = 0.1, xi = 0.11, b = 0.48.

    Returns
    -------
    figure : matplotlib.figure.Figure
        The first ten periods from rest.
    data : xarray.Dataset
        The run.

    Examples
    --------
    >>> figure, data = fig5d()
    >>> data.attrs["status"]
    'completed'
    """
    return _test_history(b=0.48, xi=0.11, omega=0.1)


def fig6() -> tuple[Figure, xr.Dataset]:
    """Fig. 6: from rest for six static forces, a = 0.3, omega = 0.1, xi = 0.05.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Six panels, tau from 0 to 1200.
    data : xarray.Dataset
        Trajectories over ``parameter`` and ``time``.

    Examples
    --------
    >>> figure, data = fig6()
    >>> data.sizes["parameter"], round(float(data["v"].max()))
    (6, 591)
    """
    return _six_forces(0.0, 1200.0)


def fig7() -> tuple[Figure, xr.Dataset]:
    """Fig. 7: the same histories for tau from 800 to 1200.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Six panels.
    data : xarray.Dataset
        Trajectories over ``parameter`` and ``time``.

    Examples
    --------
    >>> figure, data = fig7()
    >>> float(data["time"][0]) >= 800.0
    True
    """
    return _six_forces(800.0, 1200.0)


def _test_history(b: float, xi: float, omega: float) -> tuple[Figure, xr.Dataset]:
    run = simulate(moling(a=0.5, b=b, xi=xi, omega=omega), periods=10)
    figure, (ax,) = print_figure(width=12.0, height=6.5)
    _draw(run, ax, None)
    given = rf"$a = 0.5$, $b = {b:g}$, $\xi = {xi:g}$, $\omega = {omega:g}$"
    figure.suptitle(given, fontsize=_TEXT)
    return figure, run


def _draw(run: xr.Dataset, ax: Axes, span: tuple[float, float] | None, legend: bool = True) -> None:
    ax.set_xlabel(_TIME)
    ax.set_ylabel(_DISPLACEMENT)
    time_history(run, ["x", "v"], ax=ax, time_range=span, labels=_LABELS, legend=legend)


def _six_forces(began: float, ended: float) -> tuple[Figure, xr.Dataset]:
    figure, axes = print_figure(3, 2, width=16.0, height=17.0)
    kept = []
    for panel, (b, ax) in enumerate(zip(_FORCES, axes, strict=True)):
        run = simulate(moling(b=b), t_end=ended)
        _draw(run, ax, (began, ended), legend=False)
        ax.set_title(f"({'abcdef'[panel]}) b = {b:g}", loc="left", fontsize=_TEXT)
        if panel < 4:
            ax.set_xlabel("")
        if panel % 2:
            ax.set_ylabel("")
        part = run[_KEPT].sel(time=slice(began, ended))
        part.attrs = {name: run.attrs[name] for name in _ATTRIBUTES}
        kept.append(part.assign({name: run.attrs[name] for name in ("system", "status")}))
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(
        handles,
        labels,
        loc="outside upper center",
        ncols=2,
        frameon=False,
        fontsize=_TEXT,
        title=r"$a = 0.3$, $\xi = 0.05$, $\omega = 0.1$",
        title_fontsize=_TEXT,
    )
    data = xr.concat(kept, "parameter")
    return figure, data.assign_coords(b=("parameter", list(_FORCES)))


# The motion of the mole taken apart: phases of a period, and drift against oscillation.
#
# The chapter prints the parameters of neither Fig. 9 nor Fig. 11; both are drawn here for the
# period-one motion of Fig. 7(d).

_TIME_PHASES = r"time, $\tau$"
_NAMES_PHASES = {"x": "mass, x", "z": "slider top, z", "v": "slider bottom, v"}
_PROGRESSION = 2  # number of the mode


def fig11(b: float = 0.15) -> tuple[Figure, xr.Dataset]:
    """Fig. 11: drifting motion, bounded oscillation p, and progression v.

    Parameters
    ----------
    b : float, optional
        Static force; the chapter does not print the parameters of this figure.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Three panels.
    data : xarray.Dataset
        The run from rest.

    Examples
    --------
    >>> figure, data = fig11()
    >>> len(figure.axes)
    3
    """
    run = simulate(moling(b=b), periods=12)
    figure, axes = print_figure(3, 1, width=12.0, height=15.0, share_x=True)
    panels = (
        (["x", "v"], "displacement", "(a) drifting motion"),
        (["p"], "displacement, $p = x - v$", "(b) bounded oscillation of the mass"),
        (["v"], "displacement, $v$", "(c) progression of the slider bottom"),
    )
    for ax, (names, label, title) in zip(axes, panels, strict=True):
        ax.set_ylabel(label)
        ax.set_xlabel(_TIME_PHASES)
        time_history(run, names, ax=ax, labels=_NAMES_PHASES, legend=False)
        ax.set_title(title, loc="left", fontsize=_TEXT)
    axes[2].lines[0].set(**{name: axes[0].lines[1].properties()[name] for name in _LOOK})
    for ax in axes[:-1]:
        ax.set_xlabel("")
    axes[0].legend(loc="upper left", frameon=False, fontsize=_TEXT)
    run.attrs["note"] = f"parameters of Fig. 7, b = {b:g}; the chapter prints none for this figure"
    return figure, run


_LOOK = ("color", "linestyle", "linewidth")  # one curve looks the same in both panels


def period_one_phases(b: float = 0.15) -> tuple[Figure, xr.Dataset]:
    """Phases of one period of a period-one motion, as in Fig. 9, with both contacts enlarged.

    Parameters
    ----------
    b : float, optional
        Static force; the chapter does not print the parameters of Fig. 9.

    Returns
    -------
    figure : matplotlib.figure.Figure
        One period from the beginning of progression, and blow-ups of its two contacts.
    data : xarray.Dataset
        The period and its event log; time and drift are zero where it begins.

    Examples
    --------
    >>> figure, data = period_one_phases()
    >>> data.attrs["phases"]
    'progression contact no_contact contact'
    """
    run = _one_period(b)
    began, left, released, hit = run["event_time"].values[:4]
    ended = float(run["time"][-1])
    figure, axes = print_figure(3, 1, width=12.0, height=18.0)
    panels = (
        ("(a) one period", (began, ended)),
        ("(b) end of progression", (2.5 * left - 1.5 * released, 2.5 * released - 1.5 * left)),
        ("(c) impact", (2.0 * hit - ended, ended)),
    )
    numerals = dict(zip((began, left, released, hit), ("I", "II", "III", "IV"), strict=True))
    for ax, (title, window) in zip(axes, panels, strict=True):
        ax.set_xlabel(r"time since progression began, $\tau - \tau_0$")
        ax.set_ylabel("displacement")
        phases(
            run, list(_NAMES_PHASES), ax=ax, time_range=window, labels=_NAMES_PHASES, legend=False
        )
        ax.set_title(title, loc="left", fontsize=_TEXT)
        _number_phases(ax, numerals, window)
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(
        handles, labels, loc="outside upper center", ncols=2, frameon=False, fontsize=_TEXT
    )
    return figure, run


def _one_period(b: float) -> xr.Dataset:
    """One period of the settled motion from the beginning of progression, where v is zero."""
    system = moling(b=b)
    settled = simulate(system, simulate(system, periods=_SETTLED), periods=2)
    begins = settled["event_to"].values == _PROGRESSION
    first = int(np.flatnonzero(begins & (settled["event_kind"].values != "start"))[0])
    state = dict(zip("pyq", settled["state_after"].values[first], strict=False))
    # the phase of the forcing is moved, so that time counts from the beginning of progression
    values = system.parameter_values
    phase = values["phi"] + values["omega"] * float(settled["event_phase"][first])
    system = system.with_parameters(phi=phase)
    # two contacts last a hundredth of a period or less: samples stand closer round them
    switches = settled["event_time"].values[first : first + 5]
    switches = switches - switches[0]
    period = settled.attrs["period"]
    times = np.concatenate(
        [np.linspace(0.0, period, 1001)]
        + [np.linspace(max(0.0, t - 1.0), min(period, t + 1.0), 2001) for t in switches]
    )
    run = simulate(system, state, mode="progression", times=np.unique(times))
    run.attrs["phases"] = " ".join(phase_word(run, 0.0, (1.0 - 1e-9) * period))
    run.attrs["note"] = f"parameters of Fig. 7, b = {b:g}; the chapter prints none for Fig. 9"
    return run


def _number_phases(ax: Axes, numerals: dict[float, str], window: tuple[float, float]) -> None:
    """Roman numerals of the chapter in the phases that are wide enough to hold them."""
    edges = [*numerals, float("inf")]
    for (start, numeral), end in zip(numerals.items(), edges[1:], strict=True):
        low, high = max(start, window[0]), min(end, window[1])
        if high - low > 0.03 * (window[1] - window[0]):
            ax.text(
                0.5 * (low + high), 0.05, numeral, transform=ax.get_xaxis_transform(),
                ha="center", va="bottom", fontsize=_TEXT,
            )  # fmt: skip
