"""What a model is: texts, their meaning, checks, and the arrays made of them.

The files hold what users name: `System`, `Mode` and `Exit` (``parts``), `Surface` and `Signal`, the
fields of a system (``data``), and what is made of a system: a section, a smoothed system, values of
slow parameters. Each folder imports only from those named before it:

- ``text``: expressions as trees, the grammar that reads them, their values;
- ``algebra``: expressions that share their parts, derivatives, linear forms, comparison by numbers;
- ``equations``: the equations of one mode, piecewise calls resolved, slaved states solved for;
- ``cells``: a mode split at its switching surfaces, sliding on them, rest at a wall;
- ``compile``: what a mode comes to, code for Taylor series, the arrays of the engine;
- ``model``: checks, numbers for the present parameters, TOML, matrices, explanation;
- ``symmetry``: whether a declared symmetry holds, and what it does to modes and exits.
"""
