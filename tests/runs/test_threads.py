"""Threads: the same answers in the same order, however many cores there are."""

import threading

import pytest

from pyport.runs import workers


@pytest.mark.parametrize("cores", [1, 2])
def test_answers_come_in_the_order_of_the_items(monkeypatch, cores):
    """With two cores two items are on their way at once."""
    monkeypatch.setattr(workers, "_cores", lambda: cores)
    meet = threading.Barrier(cores)

    def work(item):
        meet.wait(timeout=10)
        return 2 * item

    assert list(workers.in_order(work, iter(range(4)))) == [0, 2, 4, 6]


def test_what_a_thread_raises_is_raised(monkeypatch):
    """None of it is lost."""
    monkeypatch.setattr(workers, "_cores", lambda: 2)

    with pytest.raises(ZeroDivisionError):
        list(workers.in_order(lambda item: 1 / item, [1, 0]))
