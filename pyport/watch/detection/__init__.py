"""From past recordings to a test for changes: a filter of what is known, a detector beside it."""
