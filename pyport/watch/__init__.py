"""All night at the telescope: what changed, since when and how much, few false alarms promised."""

from __future__ import annotations

from pyport.watch.alarms import Alarm
from pyport.watch.watch import Event, Seen, Watch

__all__ = ["Alarm", "Event", "Seen", "Watch"]
