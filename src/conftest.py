"""Pictures that examples in docstrings draw are closed after each of them.

pyplot keeps those that are new, and warns of more than twenty.
"""

import sys

import pytest


@pytest.fixture(autouse=True)
def closed_figures():
    yield
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")
