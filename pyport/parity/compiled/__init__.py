"""The Fortran compiled and called, and its answers stored."""
