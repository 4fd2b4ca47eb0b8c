"""A finished model in use: offsets anywhere, where to drive, how it compares with another."""
