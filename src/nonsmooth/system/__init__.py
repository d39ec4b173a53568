"""What a model is: texts, their meaning, checks, and the arrays made of them.

What users name lies here: `System`, `Mode` and `Exit` (``parts``), `Surface`, `Signal`, and what is
made of a system: a section, a smoothed system, slow parameters. The folders, each of which imports
from those above it only:

- ``text``: expressions as trees, the grammar that reads them, their values;
- ``algebra``: expressions that share their parts, derivatives, linear forms, comparison by numbers;
- ``equations``: the equations of one mode, piecewise calls resolved, slaved states solved for;
- ``cells``: a mode split at its switching surfaces, sliding on them, rest at a wall;
- ``compile``: what a mode comes to, code for Taylor series, the arrays of the engine;
- ``model``: the data of a system, checks, numbers for its parameters, TOML, matrices, explanation;
- ``symmetry``: whether a declared symmetry holds, and what it does to modes and exits.
"""
