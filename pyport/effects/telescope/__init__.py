"""What the telescope does: mount, drives, encoders, structure, receivers, the weather on it."""
