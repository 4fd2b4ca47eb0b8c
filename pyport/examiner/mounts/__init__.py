"""Recordings of mounts that are not alt-azimuth: nothing hidden, one cause, two, or an unknown."""
