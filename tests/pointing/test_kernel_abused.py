"""The compiled kernel called with whatever a buffer can be: it answers or refuses, and no more.

`make sanitize` draws 20,000 calls with every access watched, and arrays of 2^31 rows.
"""

from __future__ import annotations

import ctypes
import mmap
import os
import re
from pathlib import Path

import numpy as np
import pytest

from pyport.pointing import kernel

compiled = kernel.KERNEL
if compiled is None:
    pytest.skip("the kernel is not installed: make wheel", allow_module_level=True)

#: Calls that are drawn; under sanitizers more.
ROUNDS = os.environ.get("PYPORT_KERNEL_ROUNDS", "")
PARAMETERS = 22
ODD = np.array([0.0, -0.0, 1.0, -1.0, np.nan, np.inf, -np.inf, 5e-324, -1e-310, 1e308, -1e308,
                1e6, np.nextafter(1e6, 2e6), np.pi / 2, 1e-160, 2.0**52, 2.0**63])  # fmt: skip
#: The arguments of each function before its arrays, and how long these may be: of sizes n and k.
FUNCTIONS = {
    "scattered": ((True, False), lambda n, _: (PARAMETERS, n, n, n, n)),
    "grid": ((True, False), lambda n, k: (PARAMETERS, n, k, n * k, n * k)),
    "look_up": ((), lambda n, k: (k + 2, 3, 6 * k + 12, n, n, n, n)),
    "gram": ((), lambda n, k: (n * k, n, n, k * k, k)),
    "median": ((), lambda n, _: (n,)),
    "elementary": ((0, 1, 2, 3, -1, 2**31 - 1), lambda n, _: (n, n, n)),
}


def numbers(rng, size):
    """Return numbers, ordinary and odd, ordered or not."""
    found = rng.normal(size=size) * 10.0 ** rng.integers(-3, 4)
    odd = rng.random(size) < rng.choice([0, 0, 0.3, 1])
    found[odd] = rng.choice(ODD, size)[odd]
    return np.sort(found) if rng.random() < 0.5 else found


def spoilt(rng, array):
    """Return an array as a buffer of another shape, stride, type, place or owner."""
    size = len(array)
    ways = (
        lambda: np.repeat(array, 2)[::2],
        lambda: array[::-1],
        lambda: array.astype("f4"),
        lambda: array.astype(">f8"),
        lambda: array.astype("i8"),
        lambda: array.astype(complex),
        lambda: array[:, None],
        lambda: array.reshape(1, 1, size),
        lambda: np.broadcast_to(array, (2, size)),
        lambda: np.broadcast_to(np.float64(1), (size,)),
        lambda: np.lib.stride_tricks.as_strided(array[:1], (2**31,), (0,)),
        lambda: array[:-1] if size else np.zeros(1),
        lambda: np.append(array, 0.0),
        lambda: np.zeros(0),
        lambda: memoryview(bytearray(8 * size + 8))[1 : 8 * size + 1].cast("d"),
        lambda: np.frombuffer(bytearray(8 * size + 8), "f8", size, 3),
        lambda: np.frombuffer(array.tobytes(), "f8"),
        array.tobytes,
        array.tolist,
        lambda: None,
        lambda: np.array(1.0),
        lambda: array.astype("M8[s]"),
        lambda: array.astype(object),
    )
    return ways[rng.integers(len(ways))]()


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", FUNCTIONS)
def test_whatever_buffers_it_is_given(name):
    """It answers with a number or refuses with a TypeError, ValueError or BufferError."""
    rng = np.random.default_rng(list(name.encode()))
    before, sizes_of = FUNCTIONS[name]
    best, outcomes = compiled.level(), {"answered": 0, "refused": 0}
    for _ in range(int(ROUNDS or 300)):
        compiled.choose(str(rng.choice(compiled.levels())))
        n, k = (int(one) for one in rng.choice([0, 1, 2, 7, 127, 128, 129, 300], 2))
        sizes = sizes_of(n, k % 9)
        given = [numbers(rng, size) for size in sizes]
        some = rng.choice([0, 0, 1, 2])
        for which in rng.choice(len(given), min(some, len(given)), replace=False):
            given[which] = spoilt(rng, given[which])
        if rng.random() < 0.2:  # one array in the place of another: results overlap what is read
            given[rng.integers(len(given))] = given[rng.integers(len(given))]
        first = (before[rng.integers(len(before))],) if before else ()
        try:
            assert isinstance(getattr(compiled, name)(*first, *given), int | float)
            outcomes["answered"] += 1
        except (TypeError, ValueError, BufferError):
            outcomes["refused"] += 1
    compiled.choose(best)

    assert min(outcomes.values()) > int(ROUNDS or 300) / 20


@pytest.mark.parametrize("nodes", [[1.0, 1.0], [0.0, 5e-324], [-1e308, 1e308], [np.nan, 1.0],
                                   [2.0, 1.0], [0.0, np.inf]])  # fmt: skip
def test_a_table_without_extent_holds_no_place(nodes):
    """All places lie beyond a table whose nodes are no axis; nothing is read by them."""
    axis, other = np.array(nodes), np.array([0.0, 1.0])
    values, at, out = np.zeros(8), np.full(3, nodes[0]), np.full((2, 3), 7.0)
    within = np.full(3, 0.5)

    assert compiled.look_up(axis, other, values, at, within, out[0], out[1]) == 3
    assert compiled.look_up(other, axis, values, within, at, out[0], out[1]) == 3


def endless(size, room):
    """Return so many doubles that share the same megabytes of memory: virtual ones."""
    libc = ctypes.CDLL(None, use_errno=True)
    libc.mmap.restype = ctypes.c_void_p
    libc.mmap.argtypes = [ctypes.c_void_p, ctypes.c_size_t, *[ctypes.c_int] * 3, ctypes.c_long]
    handle = os.memfd_create("room")
    os.ftruncate(handle, room)
    pieces = -(-8 * size // room)
    none = mmap.PROT_READ | mmap.PROT_WRITE
    base = libc.mmap(
        None, pieces * room, none, mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS | 0x4000, -1, 0
    )
    for n in range(pieces):
        placed = libc.mmap(base + n * room, room, none, mmap.MAP_SHARED | 0x10, handle, 0)
        assert placed == base + n * room
    os.close(handle)
    return np.frombuffer((ctypes.c_char * (8 * size)).from_address(base), "f8")


@pytest.mark.skipif(not ROUNDS, reason="takes a core a minute: make sanitize")
def test_more_rows_than_an_int_holds():
    """All of 2^31 and five rows are computed: indices do not wrap."""
    size = 2**31 + 5
    here, out = endless(size, 2**24), endless(size, 2**24)
    here[: 2**21] = 0.5
    assert compiled.elementary(0, here, here, out) == size
    assert abs(out[-1] - np.sin(0.5)) < 1e-15
    axis, nodes = np.array([0.0, 1.0]), np.full(8, 3.0)
    assert compiled.look_up(axis, axis, nodes, here, here, out, out) == 0
    assert out[-1] == 3.0


def test_rows_that_no_memory_holds_are_refused():
    """Angles repeated 2^40 times cost nothing to give; their offsets are a MemoryError."""
    from pyport.pointing import exact_offsets, recovered

    with pytest.raises(MemoryError):
        exact_offsets(np.broadcast_to(0.1, 2**44), 0.5, recovered())


def test_the_oldest_c_library_that_it_needs():
    """No symbol of the module is of a later glibc than the one that is promised: 2.29."""
    found = re.findall(rb"GLIBC_(\d+)\.(\d+)", Path(compiled.__file__).read_bytes())

    assert max((int(one), int(two)) for one, two in found) <= (2, 29)
