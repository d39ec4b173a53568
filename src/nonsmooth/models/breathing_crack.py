r"""The chapter's beam with a breathing crack: one mass on a stiffness that opens."""

from __future__ import annotations

from typing import Any, Literal

from nonsmooth.errors import ModelError
from nonsmooth.system.parts import Mode, Text
from nonsmooth.system.system import System

__all__ = ["breathing_crack"]


def breathing_crack(
    xi: Text = 0.014,
    eta: Text = 1.1475,
    crack: Text = 5.0,
    d: Text = 0.0,
    s: Text = 1.0,
    *,
    kappa_open: Text | None = None,
    kappa_closed: Text | None = None,
    growth: str | None = None,
    grows: Literal["frozen", "flow"] = "frozen",
) -> System:
    r"""Beam with a breathing crack, dimensionless (provisional)."""
    parameters: dict[str, Text] = {"xi": xi, "eta": eta, "d": d}
    definitions: dict[str, Text] = {}
    if kappa_open is not None and kappa_closed is not None:
        parameters |= {"kappa_open": kappa_open, "kappa_closed": kappa_closed}
    else:
        parameters |= {"crack": crack, "s": s}
        definitions |= {"kappa_closed": "s*14.327", "kappa_open": "s*4.245e-3*(20 - crack)**3"}
    more: dict[str, Any] = {"period": "2*pi/eta"}
    if growth is not None and grows == "frozen":
        more["slow"] = {"crack": growth}
    elif growth is not None:
        del parameters["crack"]
        definitions = {"crack": growth, **definitions}
        more = {}
    if growth is not None and kappa_open is not None:
        raise ModelError("growth= needs a crack length; leave out kappa_open and kappa_closed")
    return System(
        name="breathing_crack",
        states=["u", "v"],
        parameters=parameters,
        definitions=definitions | {"kappa": "where(u > 0, kappa_open, kappa_closed)"},
        outputs={"stiffness": "1 + kappa", "force": "kappa*u", "acceleration": "rate(v)"},
        modes={
            "beam": Mode(
                {"u": "v", "v": "d - 2*xi*v - u - kappa*u + eta**2*sin(eta*t)"},
                cells={"+": "open", "-": "closed"},
            )
        },
        **more,
    )
