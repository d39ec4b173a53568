"""What the tests of the study share."""

import os

import pytest
from click.testing import CliRunner

# Before anything imports matplotlib: a test machine has no screen.
os.environ["MPLBACKEND"] = "Agg"


@pytest.fixture
def call():
    """Run a command line of ``nonsmooth``; the result has exit_code, stdout and stderr."""
    from nonsmooth.cli.app import app

    def run(*arguments: object):
        return CliRunner().invoke(app, [str(argument) for argument in arguments])

    return run
