"""Arrays: each antenna's own lasting parts, what all share, where they stand, what repeats."""
