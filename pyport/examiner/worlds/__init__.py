"""Recordings with hidden causes, made by rotations and ERFA.

Nothing here shares a formula with the rest of the program. What a cause does to
a recording comes out of a telescope that is made of rotations under a sky that
is ERFA's, so that a sign or a factor that is wrong there cannot be wrong here too.
"""
