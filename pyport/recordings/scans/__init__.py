"""From scans to offsets: an antenna crosses a source, the peak comes early or late."""

from __future__ import annotations

from pyport.recordings.scans.averages import Average, averages
from pyport.recordings.scans.beam import Peak, fit_peak
from pyport.recordings.scans.measure import measure

__all__ = ["Average", "Peak", "averages", "fit_peak", "measure"]
