"""A diagnosis of others' recordings, and what it finds in short."""

from __future__ import annotations

from pyport.diagnosis.diagnose import Diagnosis, diagnose
from pyport.formats.models import load
from pyport.recordings.schema import Recordings


def diagnosed(recordings: Recordings, model: str) -> Diagnosis:
    """Return the diagnosis of some recordings beside a model or a file of one."""
    return diagnose(recordings, load(model))


def said(found: Diagnosis) -> str:
    """Return what a diagnosis finds, in short."""
    words = [
        f"{one.effect} ({one.variant})" if one.variant else one.effect for one in found.findings
    ]
    return ", ".join(words) or "nothing"
