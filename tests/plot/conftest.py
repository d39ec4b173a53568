import matplotlib.pyplot as plt
import pytest

import nonsmooth as ns


@pytest.fixture(scope="session")
def mole():
    """Twenty periods of the mole; the motion is periodic by then."""
    return ns.simulate(ns.models.moling(), periods=20)


@pytest.fixture(scope="session")
def bouncing():
    """A ball that falls from rest at height 1, g = 1; r = 0.5. Impacts at sqrt(2), 2 sqrt(2)."""
    ball = ns.System(
        name="ball",
        states=["h", "u"],
        outputs={"energy": "u*u/2 + h"},
        describe={"h": "height [m]", "u": "velocity [m/s]"},
        modes={
            "flight": ns.Mode(
                {"h": "u", "u": "-1"}, exits=[ns.Exit("h", reset={"u": "-u/2"}, name="impact")]
            )
        },
    )
    return ns.simulate(ball, {"h": 1.0}, times=[0.0, 1.0, 2.0, 2.5])


@pytest.fixture
def ax():
    figure, (axes,) = ns.plot.print_figure()
    yield axes
    figure.clear()


@pytest.fixture(autouse=True)
def close_figures():
    yield
    plt.close("all")
