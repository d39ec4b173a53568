"""Lives against closed forms, mpmath and growth one cycle after the other."""

import mpmath as mp
import numpy as np
import pytest

from fatigue.bending import bent_beam, plate
from nonsmooth.errors import OptionError, ResultWarning
from nonsmooth.fatigue import (
    Forman,
    LoadBlock,
    LoadTable,
    Paris,
    Specimen,
    Walker,
    count_cycles,
    growth_by_frequency,
    life,
    life_by_cycle,
    life_ratio,
)

FREQUENCY = 20.0


def cycles_of_plate(law, mean, amplitude, first, last):
    """Closed form for K = Y sigma sqrt(pi a) with a constant Y, by Walker's law; crack shut."""
    low, high = max(mean - amplitude, 0.0), mean + amplitude
    ratio = low / high
    unit = 0.112 * (high - low) * np.sqrt(np.pi * 1e-3)
    unit /= (1 - ratio) ** (1 - getattr(law, "gamma", 1.0))
    power = law.m / 2
    if power == 1:
        lengths = np.log(last / first)
    else:
        lengths = (first ** (1 - power) - last ** (1 - power)) / (power - 1)
    return lengths / (law.C * unit**law.m)


@pytest.mark.parametrize("m", [2.0, 2.88, 3.59, 4.5])
@pytest.mark.parametrize(("mean", "amplitude"), [(0, 100), (100, 100), (150, 50), (-20, 50)])
def test_closed_form_of_a_constant_amplitude(m, mean, amplitude):
    law = Walker(1.42e-8, m, 0.68)
    load = LoadBlock.constant_amplitude(mean, amplitude, FREQUENCY)
    found = life(plate, law, load, initial=6.4, final=18.0)
    exact = cycles_of_plate(law, mean, amplitude, 6.4, 18.0)
    assert found.attrs["life_cycles"] == pytest.approx(exact, rel=1e-11)
    assert found.attrs["life"] == pytest.approx(exact / FREQUENCY, rel=1e-11)
    middle = 32  # and on the way
    part = cycles_of_plate(law, mean, amplitude, 6.4, float(found["crack"][middle]))
    assert float(found["cycles"][middle]) == pytest.approx(part, rel=1e-11)


def test_a_counted_record_of_constant_amplitude_gives_the_same():
    """From samples through rainflow counting and the integral, to 1e-9."""
    law = Walker(1.42e-8, 3.59, 0.68)
    t = np.arange(int(10 * FREQUENCY) * 64 + 1) / (64 * FREQUENCY)
    load = 100 + 100 * np.sin(2 * np.pi * FREQUENCY * t)
    found = life(plate, law, LoadBlock.from_record(load, t), initial=6.4, final=18.0)
    exact = cycles_of_plate(law, 100, 100, 6.4, 18.0) / FREQUENCY
    assert found.attrs["life"] == pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize("law", [Paris(1.42e-8, 3.59), Walker(1.42e-8, 3.59, 0.68)])
def test_specimen_against_mpmath(law):
    load = LoadBlock.constant_amplitude(150, 100, FREQUENCY)
    found = life(bent_beam, law, load, initial=6.4, final=18.0)
    with mp.workdps(30):

        def slowness(crack):
            size, ratio = bent_beam(mp.mpf(200), crack, mp), mp.mpf(50) / 250
            size /= (1 - ratio) ** (1 - mp.mpf(getattr(law, "gamma", 1)))
            return 1 / (mp.mpf(law.C) * size ** mp.mpf(law.m))

        exact = mp.quad(slowness, [mp.mpf("6.4"), 9, 12, 15, 18]) / 20
    assert found.attrs["life"] == pytest.approx(float(exact), rel=1e-10)


def test_fracture_by_closed_form():
    load = LoadBlock.constant_amplitude(100, 100, FREQUENCY)
    found = life(plate, Paris(1e-8, 3), load, initial=2.0, final=500.0, toughness=20.0)
    exact = 1e3 / np.pi * (20.0 / (0.112 * 200)) ** 2
    assert found.attrs["ended"] == "fracture"
    assert found.attrs["final"] == pytest.approx(exact, rel=1e-13)
    far = life(plate, Paris(1e-8, 3), load, initial=2.0, final=50.0, toughness=20.0)
    assert far.attrs["ended"] == "final length" and far.attrs["final"] == 50.0


def test_a_table_of_loads_by_closed_form():
    """K that knows no crack: the growth is linear in length, the time a logarithm."""

    def constant(load, crack):
        return 0.05 * load + 0.0 * crack

    law = Paris(1e-7, 3.0)
    blocks = [LoadBlock.constant_amplitude(0, size, FREQUENCY) for size in (100.0, 200.0)]
    found = life(constant, law, LoadTable([6.0, 16.0], blocks), initial=6.0, final=16.0)
    slow, fast = (FREQUENCY * 1e-7 * (0.05 * size) ** 3 for size in (100.0, 200.0))
    assert found.attrs["life"] == pytest.approx(10 / (fast - slow) * np.log(fast / slow), rel=1e-11)
    outside = life(constant, law, LoadTable([7.0, 8.0], blocks), initial=6.0, final=9.0)
    parts = 1 / slow + np.log(fast / slow) / (fast - slow) + 1 / fast
    assert outside.attrs["life"] == pytest.approx(parts, rel=1e-11)


def test_loads_as_a_function_of_the_crack():
    """A load that falls as the root of the length keeps K, and so the growth, constant."""

    def falling(crack):
        return LoadBlock.constant_amplitude(0, 100 / np.sqrt(crack), FREQUENCY)

    law = Paris(1e-7, 3.0)
    found = life(plate, law, falling, initial=6.0, final=16.0)
    rate = FREQUENCY * float(law.rate(plate(100.0, 1.0)))
    assert found.attrs["life"] == pytest.approx(10 / rate, rel=1e-11)
    assert found.attrs["life_cycles"] == pytest.approx(FREQUENCY * 10 / rate, rel=1e-11)


def test_cycle_by_cycle_closes_in_on_the_integral():
    """Forward steps lag behind: the life is longer in proportion to the growth per cycle."""
    block = LoadBlock([50.0, -20.0, 100.0], [250.0, 180.0, 160.0], [1.0, 1.0, 2.0], 0.2)
    off = []
    for C in (1.6e-4, 8e-5, 4e-5):
        options = {"initial": 6.4, "final": 12.0}
        whole = life(bent_beam, Walker(C, 3.0, 0.6), block, **options).attrs["life"]
        steps = life_by_cycle(bent_beam, Walker(C, 3.0, 0.6), block, **options).attrs["life"]
        off.append(steps / whole - 1)
    assert 0 < off[2] < 5e-3
    np.testing.assert_allclose(np.divide(off[:-1], off[1:]), 2.0, rtol=0.1)


def one_after_the_other(law, block, crack, last):
    """Cycles that `life_by_cycle` takes, in the plainest way."""
    n = 0
    while True:
        k = n % block.count.size
        low, high = (float(bent_beam(x[k], crack)) for x in (block.minimum, block.maximum))
        size, ratio = high - max(low, 0.0), max(low, 0.0) / high
        step = block.count[k] * float(law.rate(size, ratio))
        if crack + step >= last:
            return n + (last - crack) / step
        crack, n = crack + step, n + 1


@pytest.mark.parametrize("law", [Walker(3e-5, 3.0, 0.6), Forman(2e-3, 3.0, 40.0), Paris(0.05, 2.0)])
def test_many_cycles_at_once_are_the_same_cycles(law):
    """Small growth and large, to fracture; each length is the one that the last cycle left."""
    block = LoadBlock([50.0, -20.0, 100.0], [250.0, 180.0, 160.0], [1.0, 0.5, 1.0], 0.2)
    sizes = []

    def counted(load, crack):
        sizes.append(np.size(crack))
        return bent_beam(load, crack)

    found = life_by_cycle(counted, law, block, initial=6.4, final=15.0)
    exact = one_after_the_other(law, block, 6.4, 15.0)
    assert float(found["time"][-1]) / 0.2 * 3 == pytest.approx(exact, rel=1e-11)
    assert len(sizes) < 200 + exact / 4  # calls of Python, and not two for each cycle
    assert sum(sizes) < 300 + 30 * exact


def test_noise_is_taken_cycle_by_cycle():
    """Rounds that never agree still give the one cycle that begins at a known length."""
    rng = np.random.default_rng(0)

    def noisy(load, crack):
        return bent_beam(load, crack) * (1 + 0.01 * rng.random(np.shape(load)))

    law = Paris(3e-3, 3.0)
    found = life_by_cycle(noisy, law, LOAD, initial=6.4, final=9.0)
    calm = life_by_cycle(bent_beam, law, LOAD, initial=6.4, final=9.0)
    assert 0.96 < found.attrs["life"] / calm.attrs["life"] < 1.0


def test_nothing_grows_below_a_threshold():
    load = LoadBlock.constant_amplitude(0, 100, FREQUENCY)
    found = life(plate, Paris(1e-8, 3, threshold=1e3), load, initial=2.0, final=9.0)
    assert found.attrs["life"] == np.inf and found.attrs["ended"] == "no growth"
    shut = LoadBlock.constant_amplitude(-200, 100, FREQUENCY)
    assert life(plate, Paris(1e-8, 3), shut, initial=2.0, final=9.0).attrs["life"] == np.inf
    whole = life(plate, Paris(1e-8, 3), shut, initial=2.0, final=9.0, closure="none")
    assert np.isfinite(whole.attrs["life"])


def test_growth_that_stops_on_the_way():
    """A load that falls as the crack grows: the curve is right until then, infinite after."""

    def falling(crack):
        return LoadBlock.constant_amplitude(0, 200 - 20 * crack, FREQUENCY)

    def constant(load, crack):
        return 0.05 * load + 0.0 * crack

    law = Paris(1e-7, 1.0, threshold=0.05 * 100.0)  # reached at 5 mm
    found = life(constant, law, falling, initial=2.0, final=9.0)
    assert found.attrs["ended"] == "no growth" and found.attrs["life"] == np.inf
    there = found["crack"].values < 4.9
    exact = np.log(160 / (200 - 20 * found["crack"].values[there])) / (20 * 0.05e-7 * FREQUENCY)
    np.testing.assert_allclose(found["time"].values[there], exact, rtol=1e-9)
    assert np.all(np.isinf(found["time"].values[found["crack"].values > 5.2]))


def test_a_threshold_that_one_of_two_cycles_passes_on_the_way():
    """A kink of the growth inside the interval: both parts in closed form."""
    law = Paris(1e-8, 4.0, threshold=float(plate(60.0, 5.0)))  # the small one works from 5 mm on
    block = LoadBlock([0.0, 0.0], [100.0, 60.0], [1.0, 1.0], 0.1)
    found = life(plate, law, block, initial=2.0, final=9.0)
    unit = [1e-8 * (0.112 * p * np.sqrt(np.pi * 1e-3)) ** 4 / 0.1 for p in (100.0, 60.0)]
    exact = (1 / 2 - 1 / 5) / unit[0] + (1 / 5 - 1 / 9) / sum(unit)
    assert found.attrs["life"] == pytest.approx(exact, rel=1e-9)


def test_ratio_of_lives():
    one, two = (LoadBlock.constant_amplitude(0, size) for size in (100.0, 200.0))
    found = life_ratio(bent_beam, Paris(1e-8, 3.5), one, two, initial=6.4, final=15.0)
    assert float(found["ratio"]) == pytest.approx(2**3.5, rel=1e-12)


def test_growth_by_frequency():
    """A fast part after a slow one: each with its own growth and its own frequency."""
    slow = 100 * np.cos(2 * np.pi * 5 * np.arange(0, 400) / 400)
    fast = 100 * np.cos(2 * np.pi * 40 * np.arange(0, 401) / 400)
    cycles = count_cycles(np.concatenate([slow, fast]), np.arange(801) / 400.0)
    law = Paris(1e-8, 3.0)
    found = growth_by_frequency(cycles, plate, law, crack=6.4, edges=[20.0])
    np.testing.assert_allclose(found["cycles_per_second"], [2.5, 20.0], rtol=1e-12)
    np.testing.assert_allclose(found["share"], [5 / 45, 40 / 45], rtol=1e-9)
    total = 45 * float(law.rate(plate(100.0, 6.4))) / 2
    assert float(found["growth"].sum()) == pytest.approx(total, rel=1e-9)


LOAD = LoadBlock.constant_amplitude(0, 100)


def test_a_growth_of_noise_ends_and_says_how_good_it_is():
    """No halving makes noise smooth: the work is bounded, and the error is told."""
    rng = np.random.default_rng(0)
    calls = []

    def noisy(load, crack):
        calls.append(np.size(crack))
        return plate(load, crack) * (1 + 0.1 * rng.random(np.shape(load * crack)))

    with pytest.warns(ResultWarning, match="not to tolerance = 1e-11"):
        found = life(noisy, Paris(1e-8, 3), LOAD, initial=2.0, final=9.0)
    assert 1e-4 < found.attrs["integration_error"] < 0.1
    assert sum(calls) < 5e6


def test_tolerances_are_kept():
    """The kink of a threshold, in closed form, to each tolerance from the finest on."""
    law = Paris(1e-8, 4.0, threshold=float(plate(60.0, 5.0)))
    block = LoadBlock([0.0, 0.0], [100.0, 60.0], [1.0, 1.0], 0.1)
    unit = [1e-8 * (0.112 * p * np.sqrt(np.pi * 1e-3)) ** 4 / 0.1 for p in (100.0, 60.0)]
    exact = (1 / 2 - 1 / 5) / unit[0] + (1 / 5 - 1 / 9) / sum(unit)
    for goal in (1e-14, 1e-6, 0.1):
        found = life(plate, law, block, initial=2.0, final=9.0, tolerance=goal)
        assert found.attrs["life"] == pytest.approx(exact, rel=max(goal, 1e-13))


def test_a_crack_that_rests_ends_the_cycles():
    with pytest.raises(OptionError, match="does not grow from 2 mm on"):
        life_by_cycle(plate, Paris(1e-8, 3, threshold=1e3), LOAD, initial=2.0, final=9.0)


@pytest.mark.parametrize("bad", [float("nan"), -1, 0.0, 1e3, 1e-16, float("inf"), "a", True, None])
def test_tolerances_that_cannot_be(bad):
    with pytest.raises(OptionError, match="tolerance = "):
        life(plate, Paris(1e-8, 3), LOAD, initial=2.0, final=9.0, tolerance=bad)
    if bad != 1e3:
        with pytest.raises(OptionError, match="most_cycles = "):
            life_by_cycle(plate, Paris(1e-8, 3), LOAD, initial=2, final=9, most_cycles=bad)


@pytest.mark.parametrize("run", [life, life_by_cycle])
@pytest.mark.parametrize(
    ("intensity", "law", "says"),
    [
        (plate, "paris", "law = 'paris': give a law of growth"),
        (plate, Paris, "give a law of growth with its constants"),
        (plate, None, "law = None"),
        (3.0, Paris(1e-8, 3), "stress_intensity = 3.0: give a function"),
        (Specimen(), Paris(1e-8, 3), r"such as Specimen\(\).stress_intensity"),
        (lambda p, a: "text", Paris(1e-8, 3), "stress_intensity gave 'text'"),
        (lambda p, a: None, Paris(1e-8, 3), "stress_intensity gave None"),
        (lambda p, a: 1j * p * a, Paris(1e-8, 3), "has to give numbers in MPa"),
    ],
)
def test_no_law_and_no_stress_intensity(run, intensity, law, says):
    with pytest.raises(OptionError, match=says):
        run(intensity, law, LOAD, initial=2.0, final=9.0)


class OneRange(Paris):
    """A law that takes one range."""

    def rate(self, delta_K, R=0.0):
        return super().rate(delta_K, R) if delta_K > 5.0 else 0.0


@pytest.mark.parametrize("run", [life, life_by_cycle])
def test_functions_that_take_no_arrays_or_fail(run):
    block = LoadBlock([0.0, 1.0], [100.0, 120.0], [1.0, 1.0], 0.1)
    options = {"initial": 6.0, "final": 9.0}
    with pytest.raises(OptionError, match=r"stress_intensity: the function fails.*TypeError"):
        run(lambda p, a: p * float(a), Paris(1e-8, 3), block, **options)
    with pytest.raises(OptionError, match=r"law: its rate fails for ranges of shape.*ValueError"):
        run(plate, OneRange(1e-8, 3), block, **options)


def test_loads_that_fail_at_a_length():
    with pytest.raises(OptionError, match="loads: the function fails at a crack of 6 mm with KeyE"):
        life(plate, Paris(1e-8, 3), lambda a: {}[a], initial=6.0, final=9.0)


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: life(plate, Paris(1e-8, 3), LOAD, initial=6.0, final=5.0), "cracks do not heal"),
        (lambda: life(plate, Paris(1e-8, 3), LOAD, initial=-1.0, final=5.0), "initial = -1"),
        (lambda: life(plate, Paris(1e-8, 3), 100.0, initial=1.0, final=5.0), "give a LoadBlock"),
        (
            lambda: life(plate, Paris(1e-8, 3), lambda a: a, initial=1.0, final=5.0),
            "has to give a LoadBlock",
        ),
        (
            lambda: life(plate, Paris(1e-8, 3), LOAD, initial=6.0, final=9.0, toughness=0.1),
            "already gives",
        ),
        (
            lambda: life(lambda p, a: p / (a - 7), Paris(1e-8, 3), LOAD, initial=6.0, final=8.0),
            "not finite at a crack of 7",
        ),
        (lambda: life(lambda p, a: 1.0, Paris(1e-8, 3), LOAD, initial=6.0, final=8.0), "broadcast"),
        (
            lambda: life_by_cycle(plate, Paris(1e-8, 3), LOAD, initial=6, final=8, most_cycles=9),
            "after 9 cycles",
        ),
        (lambda: LoadBlock([1.0], [0.0], [1.0], 1.0), "below the minimum"),
        (lambda: LoadBlock([0.0], [np.nan], [1.0], 1.0), "maximum of cycle 0"),
        (lambda: LoadBlock([0.0], [1.0], [1.0], 0.0), "duration"),
        (lambda: LoadBlock.constant_amplitude(0, -5), "amplitude = -5"),
        (lambda: LoadBlock.from_record([0.0, 1.0]), "no times"),
        (lambda: LoadTable([1.0, 1.0], [LOAD, LOAD]), "increase"),
        (lambda: LoadTable([1.0, 2.0], [LOAD]), "as many"),
    ],
)
def test_bad_input(make, text):
    with pytest.raises(OptionError, match=text), np.errstate(divide="ignore"):
        make()
