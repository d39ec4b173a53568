import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.errors import OptionError


def test_exponents_settle_on_their_values(ax):
    spectrum = ns.lyapunov_spectrum(ns.models.moling(), transient=60, record=40)
    ns.plot.exponents(spectrum, ax=ax)
    texts = [text.get_text() for text in ax.get_legend().get_texts()]
    shown = [text.split()[0].replace("\N{MINUS SIGN}", "minus ") for text in texts]
    assert shown == ["0", "minus 0.0388", "minus 1.31", "minus ∞"]
    drawn = [line.get_ydata() for line in ax.lines[:3]]
    np.testing.assert_array_equal(drawn, spectrum["running_exponent"].values.T[:3])
    assert ax.get_ylabel() == "Lyapunov exponent"


def test_the_band_is_two_standard_errors(ax):
    spectrum = ns.lyapunov_spectrum(ns.models.duffing(), transient=20, record=100, exponents=1)
    ns.plot.exponents(spectrum, ax=ax)
    low, high = ax.patches[0].get_y(), ax.patches[0].get_y() + ax.patches[0].get_height()
    assert (high - low) / 4 == pytest.approx(float(spectrum["standard_error"][0]))
    assert (high + low) / 2 == pytest.approx(float(spectrum["lyapunov_exponent"][0]))


def test_translation_plane(ax):
    x, series = 0.3, []
    for _ in range(1000):
        x = 4 * x * (1 - x)
        series.append(x)
    test = ns.zero_one_test(series)
    ns.plot.translation(test, ax=ax)
    np.testing.assert_array_equal(ax.lines[0].get_xdata(), test["p"])
    assert ax.get_title().startswith(f"K = {float(test['K']):.3f} (")


def test_harmonics_are_marked(ax):
    run = ns.simulate(ns.models.soft_impact(), periods=120, samples_per_period=32)
    data = ns.power_spectrum(run, "x", transient=100)
    ns.plot.spectrum(data, ax=ax, highest=0.85 / (2 * np.pi) * 4.5)
    marks = [line.get_xdata()[0] for line in ax.lines[:-1]]
    np.testing.assert_allclose(marks, 0.85 / (2 * np.pi) * np.arange(1, 5))
    shown = ax.lines[-1].get_ydata()
    np.testing.assert_array_equal(shown, data["amplitude"][: shown.size])


def test_power_density_without_a_period(ax):
    run = ns.simulate(ns.models.chua(), times=np.arange(0, 200, 0.1))
    ns.plot.spectrum(ns.power_spectrum(run, "x", window="hann"), "power_density", ax=ax)
    assert len(ax.lines) == 1 and ax.get_yscale() == "log"


@pytest.mark.parametrize("draw", [ns.plot.exponents, ns.plot.translation, ns.plot.spectrum])
def test_other_datasets_are_refused(mole, draw):
    with pytest.raises(OptionError, match=r"give a result of|of a result of"):
        draw(mole)
