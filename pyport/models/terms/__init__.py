"""What other programs call the terms of a pointing model, as coefficients of effects."""
