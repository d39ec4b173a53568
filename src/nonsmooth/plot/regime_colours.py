"""Colours of regimes, the same in every picture.

They begin from the scheme "muted" of P. Tol, Colour schemes, SRON/EPS/TN/09-002. Its darkest ones,
which a small area of chaos looks like, are lighter here: black is chaos. Periods n and 2n, which
often meet, differ most.
"""

__all__ = ["LONGER", "OTHER_REGIMES", "PERIODS", "REGIME_COLOURS"]

PERIODS = {
    1: "#88CCEE", 2: "#2233C8", 3: "#DDCC77", 4: "#D2566B", 5: "#158A2E", 6: "#7B2F8C",
    7: "#44AA99", 8: "#A0B508",
}  # fmt: skip
LONGER = "#B04AE0"
OTHER_REGIMES = {
    "equilibrium": "#B8F5A5",
    "locked": "#8A5A12",
    "limit-cycle": "#5C93F0",
    "quasi-periodic": "#5A5A5A",
    "chaotic": "#000000",
    "absorbed": "#DDDDDD",
    "unsettled": "#FFFFFF",
}
REGIME_COLOURS = {
    **{f"period {n}": colour for n, colour in PERIODS.items()},
    f"period > {len(PERIODS)}": LONGER,
    **OTHER_REGIMES,
}
