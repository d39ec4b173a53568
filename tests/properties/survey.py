"""Judge a range of seeds and print what came out: ``python -m properties.survey 0 1000``."""

from __future__ import annotations

import sys

from properties.cases import Verdict
from properties.distribution import printed
from properties.watched import verdicts

_EVERY = 250


def main(first: int, last: int) -> None:
    found: list[Verdict] = []
    for verdict in verdicts(range(first, last)):
        found.append(verdict)
        if verdict.complaints:
            print(f"seed {verdict.seed} ({verdict.status}): {'; '.join(verdict.complaints[:3])}")
        if len(found) % _EVERY == 0:
            print(printed(found))
        sys.stdout.flush()
    print(printed(found))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]))
