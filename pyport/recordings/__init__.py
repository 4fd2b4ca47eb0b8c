"""Measurements in: recordings from files, and the GMRT tables that come with the program."""

from __future__ import annotations

from pyport.recordings.files import read, resolve, write
from pyport.recordings.schema import Recordings, SetAside

__all__ = ["Recordings", "SetAside", "read", "resolve", "write"]
