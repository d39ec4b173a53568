"""
A return map of the mole
========================

While the mole pushes its slider on, the slider relaxes; where that ends, the phase of the
forcing tells all about the motion. So the phase at the end of one progression to that at the
next is a map of one number. The staircase from a start ends on a cycle of two: the fixed point
(empty circle) is unstable, as the graph is steeper there than -1.
"""

import nonsmooth as ns

end = ns.PoincareMap(ns.models.moling(b=0.1), "2*xi*y + q = 1", direction=-1)
found = ns.return_map(end, "phase", (0.0, 62.8), completion={"q": 1, "y": 0}, mode="contact")
ax = ns.plot.cobweb(found, 20.0, steps=80)
