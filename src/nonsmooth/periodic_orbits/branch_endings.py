"""What a branch of orbits says at its end, in the words of those who follow orbits."""

from __future__ import annotations

__all__ = ["ending_of_orbits"]

_OF_EQUATIONS = ("residual", "derivative", "test ", "matrix")  # reasons that tell of no orbit


def ending_of_orbits(ended: str, message: str, parameter: str, value: float) -> str:
    """A sentence for the end of a branch of orbits.

    Branches of any equations speak of residuals, of ``p`` and of options that orbits have not;
    ``message`` is what they say, and stays where orbits have nothing else to say.
    """
    here = f"{parameter} = {value:.10g}"
    reason = _reason(message)
    again = "begin anew with an orbit beyond it, from find_orbit with other parameters="
    return {
        "bound": f"the branch reached the bound {here}",
        "closed": "the branch came back to its start: it is a closed curve",
        "domain": f"beyond {here} the legs of the orbit are not defined{reason}, as where a guard"
        " is no longer reached or a state leaves the domain of an equation; simulate a little"
        f" beyond to see what the motion does, and {again}",
        "singular": f"at {here} the equations of the orbit do not fix one curve, as where branches"
        f" cross, or motions of any amplitude repeat; {again}",
        "smallest_step": f"no step from smallest_step= on was taken at {here}{reason}: the branch"
        " has a corner or a jump there, or an event is nearly grazed; try a smaller"
        f" smallest_step=, or {again}",
    }.get(ended, message.replace("up to p = ", f"up to {parameter} = "))


def _reason(message: str) -> str:
    """What is said in brackets behind the value, with a blank before it."""
    _, bracket, rest = message.partition(" (")
    inside, closed, _ = rest.rpartition("):")
    said = bracket and closed and not any(word in inside for word in _OF_EQUATIONS)
    return f" ({inside})" if said else ""
