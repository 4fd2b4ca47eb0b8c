"""What the sky does: sources, their computed places for a site and a time, and the atmosphere."""
