"""Sets of drawn cases: sealed before they are solved, opened once, scored."""
