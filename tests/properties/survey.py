"""Judge a range of seeds and print what came out: ``python -m properties.survey 0 1000``.

With a file as a third argument each verdict is a line of it; seeds that have one are not run again,
so that a survey of hours may be stopped and taken up.
"""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from pathlib import Path

from properties.cases import Verdict
from properties.distribution import printed
from properties.watched import verdicts

_EVERY = 250
_SETS = ("features", "kinds", "flows")


def main(first: int, last: int, kept: Path | None = None) -> None:
    found = _read(kept, range(first, last))
    done = {verdict.seed for verdict in found}
    for verdict in verdicts(seed for seed in range(first, last) if seed not in done):
        found.append(verdict)
        if kept:
            with kept.open("a") as lines:
                lines.write(json.dumps(asdict(verdict), default=sorted) + "\n")
        if verdict.complaints:
            print(f"seed {verdict.seed} ({verdict.status}): {'; '.join(verdict.complaints[:3])}")
        if len(found) % _EVERY == 0:
            print(printed(found))
        sys.stdout.flush()
    print(printed(found))


def _read(kept: Path | None, seeds: range) -> list[Verdict]:
    """Verdicts of these seeds that a file holds already."""
    if kept is None or not kept.exists():
        return []
    lines = [json.loads(line) for line in kept.read_text().splitlines()]
    return [
        Verdict(**{k: set(v) if k in _SETS else v for k, v in line.items()})
        for line in lines
        if line["seed"] in seeds
    ]


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), *map(Path, sys.argv[3:4]))
