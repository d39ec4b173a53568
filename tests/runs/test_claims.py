"""Claims: a part of a job has one worker as long as that worker gives signs of life."""

import json
import os
import time

import pytest

from nonsmooth.runs import claims as claims_file
from nonsmooth.runs.claims import Claims, is_recent, make_claim_folders


@pytest.fixture
def two(tmp_path):
    """The folder of a job and two workers of it, of which the first one gives no signs of life."""
    make_claim_folders(tmp_path)
    first, second = Claims(tmp_path, 0.2), Claims(tmp_path, 0.2)
    sign_of(tmp_path, first).write_text(json.dumps({"place": "another machine", "process": 1}))
    return tmp_path, first, second


def sign_of(folder, claims):
    """File that a worker touches."""
    return folder / "workers" / f"{claims.worker}.json"


def test_a_claim_holds_until_its_worker_is_silent(two):
    folder, first, second = two
    assert first.take("2") and not second.take("2")
    for _ in range(4):  # longer than the patience, with signs of life
        time.sleep(0.1)
        os.utime(sign_of(folder, first))
        assert not second.take("2")
    time.sleep(0.25)
    assert second.take("2")
    first.release("2")  # of one that was only slow: the claim is not its own any more
    assert claims_file._holder(folder / "claims" / "2") == second.worker
    second.release("2")
    assert first.take("2")


def test_clocks_may_differ_by_hours(two):
    """Only changes count, by the clock of who looks."""
    folder, first, second = two
    assert first.take("0")
    for hours in (-5, 7):
        at = time.time() + 3600 * hours
        os.utime(sign_of(folder, first), (at, at))
        assert not second.take("0")
    time.sleep(0.25)
    assert second.take("0")


@pytest.mark.skipif(os.name != "posix", reason="other systems do not tell whether a process runs")
def test_the_claim_of_an_ended_process_of_this_machine_counts_no_more(two):
    folder, first, second = two
    second.patience = 1e6
    assert first.take("1")
    sign = sign_of(folder, first)
    sign.write_text(json.dumps({"place": claims_file._place(), "process": os.getpid()}))
    assert is_recent(folder, "1") and not second.take("1")
    sign.write_text(json.dumps({"place": claims_file._place(), "process": 2**22 + 1}))
    assert not is_recent(folder, "1")
    assert second.take("1")
    assert not sign.exists()


def test_a_claim_without_a_worker_counts_no_more(two):
    folder, first, second = two
    assert first.take("1")
    sign_of(folder, first).unlink()
    assert second.take("1")
    (folder / "claims" / "4").write_text("")  # its writer was killed between two steps
    assert not second.take("4")
    time.sleep(0.25)
    assert second.take("4")


def test_a_claim_that_was_made_anew_is_not_taken_away(two):
    folder, first, second = two
    path = folder / "claims" / "0"
    path.write_text("third")
    second._take_away(path, first.worker)
    assert path.read_text() == "third"
    assert [each.name for each in path.parent.iterdir()] == [path.name]
