"""What was found: its name if the recordings can carry one, its numbers, its words."""
