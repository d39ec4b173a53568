"""`published_laws`: laws of growth of aluminium 2024 with constants of published sources."""

from __future__ import annotations

from nonsmooth.fatigue.growth_laws import Forman, Paris, Walker

__all__ = ["published_laws"]

_DOWLING = (
    "N. E. Dowling, Mechanical Behavior of Materials, constants for the Walker equation:"
    " 2024-T3 (sheet), R >= 0; no copy of the table was at hand, so the digits are unverified; the"
    " rates are 1.1 to 1.6 times those of the Paris lines of doi 10.2478/fas-2022-0004 for"
    " 2024-T351 at R = 0.1 to 0.3, and 2 to 4 times at R = 0.5"
)
_LINES = (
    "Fatigue of Aircraft Structures (2022), doi 10.2478/fas-2022-0004, coefficients of Paris's law"
    " for 2024-T351, specimens 10 mm thick, R = 0.1; read as mm per cycle and MPa sqrt(m)"
)
_SCHWARMANN = (
    "L. Schwarmann, Material data of high-strength aluminium alloys for durability evaluation of"
    " structures, Aluminium-Verlag (1986), 2024-T351 plate; taken from the tables of the program"
    " easigrow, which quotes it"
)


def published_laws() -> dict[str, Paris | Walker | Forman]:
    """Laws of crack growth of aluminium 2024 by name, each with its source.

    ================== ==================================================== =================
    name               constants (mm per cycle, MPa sqrt(m))                material
    ================== ==================================================== =================
    walker 2024-T3     C = 1.42e-8, m = 3.59, gamma = 0.680                 sheet, R >= 0
    paris 2024-T3      the same at R = 0, the load ratio left out           sheet, R = 0
    paris 2024-T351    C = 1.0e-8, m = 3.645, the load ratio left out       R = 0.1
    forman 2024-T351   C = 5.00e-6, m = 2.88, K_c = 63.2                    plate
    ================== ==================================================== =================

    All describe the straight middle part of the curve of growth, about 5 to 30 MPa
    sqrt(m), in laboratory air. None has a threshold, and the source's specimens were not those of
    the chapter: below some 4 MPa sqrt(m), where most of its tests begin, they extrapolate.

    Returns
    -------
    dict of str to Paris, Walker or Forman
        Laws; ``source`` of each says where it is from and what could not be verified.

    See Also
    --------
    fit_law : constants fitted to measured lives, in sample.

    Examples
    --------
    The three sources agree within a factor of 1.7 at 10 MPa sqrt(m):

    >>> import nonsmooth as ns
    >>> for name, law in ns.fatigue.published_laws().items():
    ...     print(f"{name}: {float(law.rate(10.0)):.2e} mm/cycle")
    walker 2024-T3: 5.52e-05 mm/cycle
    paris 2024-T3: 5.52e-05 mm/cycle
    paris 2024-T351: 4.42e-05 mm/cycle
    forman 2024-T351: 7.13e-05 mm/cycle
    """
    return {
        "walker 2024-T3": Walker(C=1.42e-8, m=3.59, gamma=0.680, source=_DOWLING),
        "paris 2024-T3": Paris(C=1.42e-8, m=3.59, source=f"{_DOWLING}; at R = 0"),
        "paris 2024-T351": Paris(C=1.0e-8, m=3.645, source=_LINES),
        "forman 2024-T351": Forman(C=5.00e-6, m=2.88, K_c=63.2, source=_SCHWARMANN),
    }
