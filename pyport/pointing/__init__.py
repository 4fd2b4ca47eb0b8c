"""pointing."""
