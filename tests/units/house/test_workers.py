"""Work that is shared out: the same results in the same order, by processes that are begun where it pays."""

from __future__ import annotations

import os
import time
import warnings

import pytest

from pipeclamp_models.base import processes
from pipeclamp_models.base.errors import UserError
from pipeclamp_models.base.processes import ALONE, Workers, spread


def slowly(job: int) -> tuple[int, int]:
    time.sleep(0.02)
    return job, os.getpid()


def refusing(job: int) -> int:
    if job == 3:
        raise UserError("three is refused")
    return job


def test_short_work_stays_in_this_process():
    results = list(Workers(2).share(slowly, range(6)))
    assert results == [(job, os.getpid()) for job in range(6)]


def test_long_work_goes_to_others_in_order_and_they_stay(monkeypatch):
    monkeypatch.setattr(processes, "BEGINNING_S", 0.05)
    workers = Workers(2)
    results = list(workers.share(slowly, range(12)))
    assert [job for job, _ in results] == list(range(12))
    mine = [process == os.getpid() for _, process in results]
    assert mine[0] and not mine[-1] and mine == sorted(mine, reverse=True)
    again = list(workers.share(slowly, range(3)))
    assert os.getpid() not in {process for _, process in again}


@pytest.mark.parametrize("workers", [Workers(2), ALONE])
def test_a_mistake_in_the_work_is_the_callers(workers, monkeypatch):
    monkeypatch.setattr(processes, "BEGINNING_S", 0.0)
    with pytest.raises(UserError, match="three is refused"):
        list(workers.share(refusing, range(6)))


def test_who_works_alone_begins_none(monkeypatch):
    monkeypatch.setattr(processes, "BEGINNING_S", 0.0)
    assert {process for _, process in ALONE.share(slowly, range(4))} == {os.getpid()}


def test_a_process_that_is_begun_anew_is_no_warning(recwarn):
    def jobs():
        warnings.warn("A worker stopped while some jobs were given to the executor. This can be ...", stacklevel=1)
        yield from (-1, -2)

    assert list(spread(abs, jobs(), 2)) == [1, 2]
    assert not [one for one in recwarn if "worker" in str(one.message)]
