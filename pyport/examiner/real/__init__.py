"""Recordings of real telescopes put to the program, beside what was published of them."""
