"""Systems that a visitor types: rebounds that accumulate at once, and one without parameters."""

ZENO = """name = "zeno"
states = ["x", "v"]
period = "1"

[parameters]
r = 0.5

[modes.fly.flow]
x = "v"
v = "-1"

[[modes.fly.exits]]
guard = "x"
reset = {v = "-r*v"}
name = "hit"
"""

RIGID = """states = ["x", "v"]
period = "2*pi"

[equations]
x = "v"
v = "sin(t) - v - x"
"""
