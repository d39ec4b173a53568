"""Pages that list what is in a result list all of it."""

import re
from pathlib import Path

import pytest

import nonsmooth as ns

GUIDES = Path(__file__).parents[2] / "docs" / "how-to"


def run():
    return ns.simulate(ns.models.moling(), periods=2, tangent=["b"])


def diagram():
    return ns.bifurcation_diagram(ns.models.moling(), "b", [0.1, 0.2], transient=2, record=4)


def ensemble():
    return ns.ensemble(ns.models.moling(), {"v": [0.0, 0.1]}, record=3)


@pytest.mark.parametrize(
    ("page", "make"),
    [
        ("results.md", run),
        ("diagrams.md", diagram),
        ("ensembles.md", ensemble),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_every_variable_is_on_the_page(page, make):
    system = ns.models.moling()
    told = set(re.findall(r"`(\w+)`", (GUIDES / page).read_text(encoding="utf-8")))
    missing = set(make().variables) - told - {*system.states, *system.outputs}
    # drifts are told of a state that the page has chosen
    missing = {name for name in missing if not name.startswith("v_per_")}
    assert not missing, f"add to a table of docs/how-to/{page}: {sorted(missing)}"
