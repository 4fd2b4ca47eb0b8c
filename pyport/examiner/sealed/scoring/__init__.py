"""What answers are worth: each held to its truth, all as one score, with pictures and a page."""
