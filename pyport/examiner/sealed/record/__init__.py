"""What is kept of a set, and read back: its files, its code, its answers, its history."""
