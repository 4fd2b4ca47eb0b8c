"""What seals are made of."""

from __future__ import annotations

import hashlib
from pathlib import Path

from pyport.files import tree

#: The program on trial, and the part of it that examines.
PACKAGE = Path(__file__).parents[2]
EXAMINER = Path(__file__).parents[1]


def commitment(nonce: str, text: str) -> str:
    """Return SHA-256(nonce || text) as hexadecimal, the nonce given as hexadecimal too.

    The nonce, 256 random bits, keeps anyone from guessing a truth and checking the guess.
    """
    return hashlib.sha256(bytes.fromhex(nonce) + text.encode("utf-8")).hexdigest()


def solver() -> str:
    """Return the tree hash of the program without its examiner."""
    return tree(PACKAGE, without=EXAMINER)


def examiner() -> str:
    """Return the tree hash of the examiner, the scoring script in it."""
    return tree(EXAMINER)
