"""What strobes and sections answer alike, as the base of maps says."""

import pickle

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.runs.maps import Map

MAPS = {
    "strobe": ns.StroboscopicMap(ns.models.soft_impact()),
    "forced section": ns.PoincareMap(ns.models.soft_impact(), "v"),
    "free section": ns.PoincareMap(ns.models.chua(), "y"),
}


@pytest.mark.parametrize("kind", MAPS)
def test_powers_and_parameters_keep_the_kind(kind):
    chosen = MAPS[kind]
    assert isinstance(chosen, Map)
    assert chosen**3 == chosen.power(3) != chosen
    assert type(chosen**2) is type(chosen)
    assert ((chosen**2) ** 3).every == 6
    name = next(iter(chosen.system.parameters))
    changed = chosen.with_parameters(**{name: 0.4})
    assert changed.system.parameter_values[name] == 0.4
    assert changed == pickle.loads(pickle.dumps(changed))
    with pytest.raises(ns.OptionError, match="power 0 of a map"):
        chosen.power(0)


def test_only_points_of_a_section_with_forcing_have_a_time():
    assert {kind: chosen.points_have_time for kind, chosen in MAPS.items()} == {
        "strobe": False,
        "forced section": True,
        "free section": False,
    }


def test_a_section_with_forcing_says_that_states_do_not_suffice():
    MAPS["strobe"].check_states_suffice("attractors")
    MAPS["free section"].check_states_suffice("attractors")
    with pytest.raises(ns.OptionError, match="take its StroboscopicMap"):
        MAPS["forced section"].check_states_suffice("attractors")


@pytest.mark.parametrize("kind", ["strobe", "free section"])
def test_runners_give_the_points_that_the_map_gives(kind):
    chosen = MAPS[kind]
    names = list(chosen.system.states)
    points = chosen.iterate(dict.fromkeys(names, 0.3), 3)[names].to_array().values.T
    runner = chosen.runner(1e-12)
    states, _ = runner.iterate(runner.start(points[:1]), 2)
    np.testing.assert_allclose(states[0], points[1:], rtol=1e-8, atol=1e-8)
    last, _ = runner.last(runner.start(points[:1]), 2)
    np.testing.assert_allclose(last[0], points[2], rtol=1e-8, atol=1e-8)
