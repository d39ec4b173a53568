"""The command line: it parses, calls the library and prints, nothing else.

Libraries are imported inside the commands that need them, so that help comes at once.
"""

from __future__ import annotations

import sys

__all__ = ["main"]


def main() -> None:
    """Run the command that ``sys.argv`` names."""
    try:
        from nonsmooth.cli.app import app

        app(prog_name="nonsmooth")
    except KeyboardInterrupt:  # while modules load; commands answer it themselves
        sys.exit(130)
