"""File formats: each module turns a file into cells, or recordings into a file."""
