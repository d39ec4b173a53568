"""Changes of the word: the orbit at the change solves the equations of both words."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.periodic_orbits.equations import OrbitEquations
from nonsmooth.periodic_orbits.word_change import changes_of_word
from periodic_orbits.kinds import found_equations


def equations_of(like: OrbitEquations, word) -> OrbitEquations:
    return OrbitEquations(like.legs, word, period=like.period, phase=like.phase, origin=like.origin)


def test_an_event_passes_the_section_and_back():
    """Begun just behind an event instead of just before it: the same orbit, another word."""
    mole = ns.models.moling()
    orbit = ns.find_orbit(mole)
    # the phase at which the first event is a hair behind the section
    phase = float(orbit["leg_time"][1] / orbit["length"]) - 1e-13
    before = ns.find_orbit(mole, phase=phase)
    equations, unknowns = found_equations(mole, before)
    turn = equations.unpack(unknowns)
    (change,) = changes_of_word(equations, turn, "leg:0")
    assert change.kind == "section" and change.grows == "leg:last"
    after = equations_of(equations, change.guess.word)
    assert after.word.modes[0] == equations.word.modes[1]
    residual = after.evaluate(after.pack(change.guess.turn))[0]
    assert np.abs(residual).max() < 1e-9
    (back,) = changes_of_word(after, change.guess.turn, "leg:last")
    assert back.guess.word == equations.word and back.grows == "leg:0"
    np.testing.assert_allclose(back.guess.turn.instants, turn.instants, atol=1e-9)


@pytest.mark.parametrize("omega", [0.85, 0.6])
def test_an_excursion_appears_and_vanishes_at_a_graze(omega):
    e, zeta = 1.26, 0.02
    a = e * np.hypot(1 - omega**2, 2 * zeta * omega) / omega**2
    system = ns.models.soft_impact(omega=omega, zeta=zeta, e=e, a=a * (1 - 1e-9))
    equations, unknowns = found_equations(system, ns.find_orbit(system, word="free"))
    turn = equations.unpack(unknowns)
    (change,) = changes_of_word(equations, turn, "graze:0:0")
    word = change.guess.word
    assert word.text(system) == "free contact free" and change.opens == 1
    touch = 0.5 * (change.guess.turn.instants[1] + change.guess.turn.instants[2])
    # the highest point of the closed form
    x = -1j * a * omega**2 / (1 - omega**2 + 2j * zeta * omega)
    top = (-np.angle(x) / omega) % (2 * np.pi / omega)
    assert touch == pytest.approx(top, abs=1e-6)
    longer = equations_of(equations, word)
    (back,) = changes_of_word(longer, change.guess.turn, "short:1")
    assert back.guess.word == equations.word and back.grows == "graze:0:0"
