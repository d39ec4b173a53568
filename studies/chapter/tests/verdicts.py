"""Single verdicts: ``verdicts.toml`` has that of each claim, and tests compare with it.

``python studies/chapter/tests/verdicts.py chapter-output/claims.json`` writes the table anew from
a run of the whole chapter, and names what has changed; the changelog tells the reason of each.
"""

import json
import sys
import tomllib
from pathlib import Path

TABLE = Path(__file__).parents[1] / "verdicts.toml"
HEAD = """\
# The verdict of each claim. Tests compare with it; tests/verdicts.py writes it from a run.
"""


def expected_verdicts(names=None):
    """Verdicts by the names of claims: of all, or of some in their order."""
    table = tomllib.loads(TABLE.read_text(encoding="utf-8"))
    return table if names is None else {name: table[name] for name in names}


def verdicts_of(rows):
    """Verdicts by the names of claims, in rows as of `evaluate_claims`."""
    return {row["id"]: row["verdict"] for row in rows}


def changes(before, after):
    """What has changed, in words."""
    names = dict.fromkeys([*before, *after])
    pairs = {name: (before.get(name, "none"), after.get(name, "none")) for name in names}
    return [f"{name}: {old}, now {new}" for name, (old, new) in pairs.items() if old != new]


def write(rows):
    """Write the table from rows of all claims; returns what has changed."""
    before = expected_verdicts() if TABLE.exists() else {}
    lines = [f'{name} = "{verdict}"\n' for name, verdict in verdicts_of(rows).items()]
    TABLE.write_text(HEAD + "".join(lines), encoding="utf-8")
    return changes(before, expected_verdicts())


if __name__ == "__main__":
    (path,) = sys.argv[1:]
    print(*write(json.loads(Path(path).read_text(encoding="utf-8"))), sep="\n")
