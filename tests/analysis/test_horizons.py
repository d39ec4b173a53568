"""For how long chaos was seen, and the bound of its escape rate, where the rate is known.

Once a period x becomes x/c or (1 - x)/c, a tent whose top stands out of [0, 1] for c < 1/2.
Motions leave where the top is: of the uniform density on [0, 1] a share of 1 - 2 c leaves in each
period and the rest is uniform again. So the escape rate is log(1/(2 c)), exactly, and the mean
lifetime 1/(1 - 2 c). What has left rests at 3. For c > 1/2 no motion leaves.
"""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.analysis.statistics.escape import escape_rate_below

STAYS = -0.05  # a leak that is none; slopes of exactly 2 would shift all digits out
STARTS = np.random.default_rng(5).uniform(0.05, 0.95, 24)


def tent(leak: float, *, calm: str = "3 + (x - 3)/2") -> ns.System:
    """The tent map with 1 - 2 c = ``leak``, as a reset in every period."""
    inside = f"where(x < 0.5, x, 1 - x)/{0.5 * (1.0 - leak)!r}"
    rule = f"where(x > 2, {calm}, where({inside} > 1, 4 + x/10, {inside}))"
    still = {"x": "0"}
    return ns.System(
        name="tent",
        states=["x"],
        parameters={"p": 0.0},
        period="2*pi",
        modes={
            "first": ns.Mode(still, exits=[ns.Exit("sin(t)", to="second")]),
            "second": ns.Mode(still, exits=[ns.Exit("-sin(t)", to="first", reset={"x": rule})]),
        },
    )


def lifetime(system: ns.System, x: float, record: int) -> int:
    """Periods until the motion leaves, by the map in Python; ``record`` where it does not."""
    points = ns.stroboscopic_map(system, {"x": x}, record=record, phase=0.25)["x"].values
    left = np.flatnonzero(points > 2.0)
    return int(left[0]) if left.size else record


def test_bound_is_that_of_the_exponential_law() -> None:
    """exp(-k N) = 0.05 at the bound, and steps of independent motions add up."""
    assert np.exp(-float(escape_rate_below(1000)) * 1000) == pytest.approx(0.05, rel=1e-12)
    assert float(escape_rate_below(5 * 200)) == float(escape_rate_below(1000))
    assert np.isnan(escape_rate_below([0, 10])).tolist() == [True, False]


def test_bound_covers_the_rate_of_lifetimes() -> None:
    """Of motions that are still there after N periods, the rate is above the bound in 5 % of cases.

    So 5 % of all motions live longer than the N at which the bound falls to the true rate: of 400,
    20 +- 4.4, and the test allows three standard errors of that count.
    """
    leak = 0.02
    rate = -np.log(1.0 - leak)
    horizon = int(np.ceil(-np.log(0.05) / rate))
    assert float(escape_rate_below(horizon)) <= rate < float(escape_rate_below(horizon - 1))
    starts = np.random.default_rng(1).uniform(0.0, 1.0, 400)
    c, x = 0.5 * (1.0 - leak), starts.copy()
    for _ in range(horizon):
        x = np.where(x <= 1.0, np.minimum(x, 1.0 - x) / c, x)
    alive = int(np.count_nonzero(x <= 1.0))
    assert abs(alive - 20) <= 3 * np.sqrt(400 * 0.05 * 0.95)


def test_the_system_has_the_rate_of_the_map() -> None:
    """Mean lifetime 1/0.05 = 20 periods; that of 24 motions scatters by 20/sqrt(24)."""
    system = tent(0.05)
    mean = np.mean([lifetime(system, x, 400) for x in STARTS])
    assert abs(mean - 20.0) < 3 * 20.0 / np.sqrt(STARTS.size)


@pytest.mark.slow
@pytest.mark.parametrize("calm", ["3 + (x - 3)/2", "3 + sin(x)/4"])
def test_no_regime_outlives_the_chaos(calm: str) -> None:
    """A label of chaos tells no more periods than the motion stays, and its bound holds."""
    leak = 1e-3
    system = tent(leak, calm=calm)
    for x in STARTS[:8]:
        stays = lifetime(system, x, 20_000)
        for confirm in (0, 1000):
            found = ns.regime(system, {"x": x}, phase=0.25, transient=20, confirm=confirm)
            seen = found["chaotic_for"].item()
            if found["regime"].item() != "chaotic":
                assert seen == 0 and np.isnan(found["escape_rate_below"].item())
                continue
            assert 0 < seen <= stays
            assert found["escape_rate_below"].item() == pytest.approx(-np.log(0.05) / seen)
            assert (
                f"chaotic for at least {seen} periods, escape rate below" in found.attrs["message"]
            )


def test_a_regime_that_has_just_left_is_looked_at_again() -> None:
    """The motion leaves 150 periods before the look behind ``confirm`` and creeps to its rest."""
    system = tent(1e-3, calm="3 + 0.99*(x - 3)")
    first_look = 20 + 2 * 100 + 100 + 2 * 500
    x, stays = next(
        (x, stays) for x in STARTS if (stays := lifetime(system, x, 20_000)) > first_look
    )
    confirm = stays + 150 - first_look
    found = ns.regime(system, {"x": x}, phase=0.25, transient=20, confirm=confirm)
    assert (found["regime"].item(), found["period"].item()) == ("periodic", 1)
    assert found["multiplier_modulus"].values == pytest.approx([0.99], abs=1e-9)


def test_exponents_of_a_torus_behind_chaos_are_told() -> None:
    """The motion escapes to a rotation, which does not repeat; its exponent is zero."""
    turn = "x > 2"
    leak = 1e-3
    inside = f"where(x < 0.5, x, 1 - x)/{0.5 * (1.0 - leak)!r}"
    still = {"x": "0", "y": "0"}
    golden = repr(float(np.pi * (np.sqrt(5.0) - 1.0)))
    system = ns.System(
        states=["x", "y"],
        period="2*pi",
        modes={
            "first": ns.Mode(still, exits=[ns.Exit("sin(t)", to="second")]),
            "second": ns.Mode(
                still,
                exits=[
                    ns.Exit(
                        "-sin(t)",
                        to="first",
                        reset={
                            "x": f"where({turn}, 4 + cos({golden})*(x - 4) - sin({golden})*y,"
                            f" where({inside} > 1, 5, {inside}))",
                            "y": f"where({turn}, sin({golden})*(x - 4) + cos({golden})*y, 0*y)",
                        },
                    )
                ],
            ),
        },
    )
    x = STARTS[0]
    stays = lifetime(system, x, 20_000)
    with pytest.warns(ns.ResultWarning, match="later the largest exponent is"):
        found = ns.lyapunov_spectrum(
            system, {"x": x}, transient=50, record=stays - 100, exponents=1, confirm=2000
        )
    assert found.attrs["settled"] == 0 and found.attrs["chaotic_for"] == 0
    label = ns.regime(system, {"x": x}, phase=0.25, transient=20, confirm=10_000)
    assert label["regime"].item() == "quasi-periodic"


@pytest.mark.slow
def test_attractors_tell_for_how_long_they_were_chaotic() -> None:
    stays = ns.attractors(ns.StroboscopicMap(tent(STAYS), phase=0.25), {"x": (0.1, 0.9)}, samples=4,
                          record=500)  # fmt: skip
    assert stays["kind"].values.tolist() == ["chaotic"]
    # the record, and half of the 4000 iterates of the exponent, of which ten steps are left out
    assert stays["chaotic_for"].values.tolist() == [500 + 4 * ((1000 - 10) // 2)]
    assert stays.attrs["message"].startswith("completed; 1 attractor is chaotic for at least 2480")
    leaves = ns.attractors(
        ns.StroboscopicMap(tent(1e-3), phase=0.25), {"x": (0.1, 0.9)}, samples=4, record=200
    )
    for kind, seen in zip(leaves["kind"].values, leaves["chaotic_for"].values, strict=True):
        assert (kind == "chaotic") == (seen > 0)
        assert kind == "periodic"  # mean lifetimes of 1000 are shorter than record and exponent


def test_a_picture_tells_it_too() -> None:
    found = ns.bifurcation_picture(
        ns.StroboscopicMap(tent(STAYS), phase=0.25), "p", (0.0, 1.0), {"x": (0.1, 0.9)},
        columns=2, samples=3, searches=0, record=300,
    )  # fmt: skip
    seen = 300 + 4 * ((250 - 10) // 2)
    assert found["chaotic_for"].values.tolist() == [[seen], [seen]]
    assert f"chaotic for at least {seen} periods, escape rate below" in found.attrs["message"]
    assert found["escape_rate_below"].values == pytest.approx(-np.log(0.05) / seen)


def test_a_map_of_regimes_tells_the_shortest() -> None:
    base = tent(STAYS)
    two = ns.System(
        states=["x"], parameters={"p": 0.0, "q": 0.0}, period="2*pi", initial={"x": 0.3},
        modes=dict(base.modes),
    )  # fmt: skip
    grid = ns.regime_map(two, {"p": [0.0, 1.0], "q": [0.0, 1.0]}, phase=0.25, confirm=500)
    seen = 1000 + 500 + 300 + 500
    assert np.all(grid["chaotic_for"].values == seen)
    assert f"; chaotic for at least {seen} periods" in grid.attrs["message"]


def test_a_diagram_runs_on_motions_without_a_period() -> None:
    system = tent(1e-3)
    x = float(STARTS[0])
    stays = lifetime(system, x, 20_000)
    options = {"initial": {"x": x}, "phase": 0.25, "transient": 50, "record": 20}
    short = ns.bifurcation_diagram(system, "p", [0.0, 1.0], **options)
    assert short["period"].values.tolist() == [[0], [0]]
    assert "have not settled to a period" in short.attrs["message"]
    assert "chaotic" not in short.attrs["message"]
    for way in ("restart", "follow up"):
        long = ns.bifurcation_diagram(
            system, "p", [0.0, 1.0], start=way, longest=50 * 2**9, **options
        )
        assert long["period"].values.tolist() == [[1], [1]]
        used = long["transient_used"].values.ravel()
        assert used[0] in [50 * 2**k for k in range(10)] and used[0] > stays >= used[0] // 2 - 20
        assert used[1] == (used[0] if way == "restart" else 50)


def test_a_diagram_of_a_section_runs_on_too() -> None:
    """Van der Pol's oscillator comes to its cycle as exp(-zeta t): to 1e-6 in 14/(2 pi zeta)."""
    oscillator = ns.System(
        states=["x", "v"],
        parameters={"zeta": 0.05},
        equations={"x": "v", "v": "zeta*(1 - x**2)*v - x"},
        initial={"x": 0.1},
    )
    section = ns.PoincareMap(oscillator, "v")
    values = [0.02, 0.05]
    short = ns.bifurcation_diagram(section, "zeta", values, transient=10, record=10)
    assert short["period"].values.tolist() == [[0], [0]]
    long = ns.bifurcation_diagram(section, "zeta", values, transient=10, record=10, longest=10_000)
    assert np.all(long["period"].values > 0)
    for column, value in enumerate(values):
        again = ns.bifurcation_diagram(
            section, "zeta", [value], transient=int(long["transient_used"][column, 0]), record=10
        )
        # the same points but for the rounding of a search that was cut elsewhere
        assert again["x"].values[0, 0] == pytest.approx(long["x"].values[column, 0], abs=1e-12)
        assert int(long["transient_used"][column, 0]) > np.log(1e4) / (2 * np.pi * value)


def test_longest_is_no_shorter_than_the_transient() -> None:
    with pytest.raises(ns.OptionError, match="longest = 10 is less than transient = 50"):
        ns.bifurcation_diagram(tent(STAYS), "p", [0.0], transient=50, longest=10)


@pytest.mark.slow
@pytest.mark.parametrize("short", [20, 200])
def test_machines_that_settle_after_long_chaos(short: int) -> None:
    """Strobes of the cracked beam repeat after two periods, those of the rotor after four.

    Both only after 1000 to 3000 periods. However short the look, no label of chaos comes without
    the periods that it was seen for, which are fewer than the transient lasts.
    """
    rotor = ns.models.rotor(
        nu1=0.06, eps_x=0.4, eps_y=0.5, eta_m=0.00289, delta_x=0.0, delta_y=0.0, eta=2.5
    )
    for system, period in ((ns.models.breathing_crack(crack=14.8), 2), (rotor, 4)):
        quick = ns.regime(system, transient=short, longest=short, confirm=0, evidence=100)
        if quick["regime"].item() == "chaotic":
            seen = quick["chaotic_for"].item()
            assert 0 < seen <= 3000
            assert f"chaotic for at least {seen} periods" in quick.attrs["message"]
        else:
            assert quick["regime"].item() in ("unsettled", "periodic")
        found = ns.regime(system)
        assert (found["regime"].item(), found["period"].item()) == ("periodic", period)
        assert found["chaotic_for"].item() == 0
