"""Every verb that begins at a point of a result heeds the parameters of that point."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.errors import OptionError

SYSTEM = ns.models.soft_impact()  # omega = 0.85
SHORT = {"transient": 5, "record": 5}
ELSEWHERE = {"omega": 0.75}
OTHERS = {"zeta": [0.01, 0.02]}
PLANE = OTHERS | {"a": [0.7, 0.8]}
SEEN = {"transient": 5, "record": 20, "evidence": 200, "confirm": 200}


VERBS = {
    "simulate": lambda start, **more: ns.simulate(SYSTEM, start, periods=2, **more),
    "stroboscopic_map": lambda start, **more: ns.stroboscopic_map(SYSTEM, start, **SHORT, **more),
    "poincare_section": lambda start, **more: ns.poincare_section(
        SYSTEM, start, section="v", **SHORT, **more
    ),
    "regime": lambda start, **more: ns.regime(SYSTEM, start, **SEEN, **more),
    "lyapunov_spectrum": lambda start, **more: ns.lyapunov_spectrum(
        SYSTEM, start, transient=5, record=20, **more
    ),
    "bifurcation_diagram": lambda start, **more: ns.bifurcation_diagram(
        SYSTEM, "zeta", OTHERS["zeta"], initial=[{}, start], **SHORT, **more
    ),
    "regime_map": lambda start, **more: ns.regime_map(
        SYSTEM, PLANE, initial=start, **SEEN, **more
    ),
    "regime_map of several": lambda start, **more: ns.regime_map(
        SYSTEM, PLANE, initial=[{}, start], **SEEN, **more
    ),
    "contact_statistics": lambda start, **more: ns.contact_statistics(
        SYSTEM, "zeta", OTHERS["zeta"], initial=start, **SHORT, **more
    ),
    "contact_statistics of one": lambda start, **more: ns.contact_statistics(
        SYSTEM, initial=start, **SHORT, **more
    ),
    "waterfall": lambda start, **more: ns.waterfall(
        SYSTEM, "zeta", OTHERS["zeta"], "x", initial=start, **SHORT, **more
    ),
    "ensemble": lambda start, **more: ns.ensemble(SYSTEM, start, **SHORT, **more),
    "ensemble of several": lambda start, **more: ns.ensemble(SYSTEM, [start], **SHORT, **more),
}  # fmt: skip


def points(where):
    """Points that belong to parameters: of an orbit, of a diagram, of a run, of strobes."""
    diagram = ns.bifurcation_diagram(SYSTEM, "omega", [where["omega"]], **SHORT)
    strobes = ns.stroboscopic_map(SYSTEM, parameters=where, **SHORT)
    return {
        "orbit": ns.find_orbit(SYSTEM, parameters=where).isel(time=0, missing_dims="ignore"),
        "diagram": diagram.isel(parameter=0, lane=0, point=0),
        "run": ns.simulate(SYSTEM, periods=2, parameters=where).isel(time=-1),
        "strobes": strobes.isel({strobes["x"].dims[0]: -1}),
    }


@pytest.fixture(scope="module")
def elsewhere():
    return points(ELSEWHERE)


@pytest.mark.parametrize("verb", VERBS)
def test_a_point_of_other_parameters_is_refused(verb, elsewhere):
    for point in elsewhere.values():
        with pytest.raises(OptionError, match=r"belongs to parameters=.*'omega': 0.75"):
            VERBS[verb](point)


@pytest.mark.parametrize("verb", VERBS)
def test_a_point_of_other_parameters_is_taken_where_these_are_told(verb, elsewhere):
    VERBS[verb](elsewhere["run"], parameters=ELSEWHERE)
    VERBS[verb](elsewhere["run"], parameters={})


@pytest.mark.parametrize("verb", VERBS)
def test_a_point_of_the_same_parameters_is_taken(verb):
    same = points({"omega": SYSTEM.parameter_values["omega"]})
    for point in same.values():
        VERBS[verb](point)


def test_what_is_swept_may_differ(elsewhere):
    start = elsewhere["diagram"]
    found = ns.bifurcation_diagram(SYSTEM, "omega", [0.75, 0.8], initial=start, **SHORT)
    assert set(found["status"].values.ravel()) == {"completed"}
    ns.contact_statistics(SYSTEM, "omega", [0.75, 0.8], initial=start, **SHORT)
    ns.regime_map(SYSTEM, {"omega": [0.75, 0.8], "a": [0.7]}, initial=start, **SEEN)
    runs = ns.ensemble(SYSTEM, start, parameters={"omega": [0.75, 0.8]}, **SHORT)
    np.testing.assert_array_equal(runs["initial_state"].sel(state="x"), [start["x"].item()] * 2)
    with pytest.raises(OptionError, match="belongs to parameters="):
        ns.ensemble(SYSTEM, start, parameters={"zeta": [0.01, 0.02]}, **SHORT)


def test_several_points_at_once_are_none_for_an_ensemble(elsewhere):
    run = ns.simulate(SYSTEM, periods=2)
    with pytest.raises(OptionError, match=r"over time; give one of its points"):
        ns.ensemble(SYSTEM, run, **SHORT)
    with pytest.raises(OptionError, match="no state 'v'"):
        ns.ensemble(SYSTEM, run.isel(time=-1).drop_vars("v"), **SHORT)
