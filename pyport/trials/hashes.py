"""What seals are made of."""

from __future__ import annotations

import hashlib
from pathlib import Path

from pyport.files import sha256

#: The program on trial, and the part of it that examines.
PACKAGE = Path(__file__).parents[1]
EXAMINER = Path(__file__).parent


def commitment(nonce: str, text: str) -> str:
    """Return SHA-256(nonce || text) as hexadecimal, the nonce given as hexadecimal too.

    The nonce, 256 random bits, keeps anyone from guessing a truth and checking the guess.
    """
    return hashlib.sha256(bytes.fromhex(nonce) + text.encode("utf-8")).hexdigest()


def tree(folder: Path, without: Path | None = None) -> str:
    """Return one SHA-256 for all files in a folder, names and bytes, compiled ones apart."""
    whole = hashlib.sha256()
    for path in sorted(folder.rglob("*")):
        left_out = without is not None and path.is_relative_to(without)
        if path.is_file() and "__pycache__" not in path.parts and not left_out:
            whole.update(f"{sha256(path)}  {path.relative_to(folder).as_posix()}\n".encode())
    return whole.hexdigest()


def solver() -> str:
    """Return the tree hash of the program without its examiner."""
    return tree(PACKAGE, without=EXAMINER)


def examiner() -> str:
    """Return the tree hash of the examiner, the scoring script in it."""
    return tree(EXAMINER)
