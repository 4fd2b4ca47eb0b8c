"""What is known by its course alone: changes in time, fields, terms that follow a condition."""
