"""Pointing models beyond a fit: completed, kept in files, applied to directions, compared."""
