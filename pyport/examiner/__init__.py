"""Recordings of known truth, and others' recordings, put to the program from outside.

`worlds` draws telescopes under a sky by rotations and ERFA; `sealed` hides their truths, opens and
scores them; `nulls` draws noise with nothing, or one cause, in it; `real` reads public recordings;
`acceptance` measures what is promised of a diagnosis. What is drawn here
has formulae of its own.
"""
