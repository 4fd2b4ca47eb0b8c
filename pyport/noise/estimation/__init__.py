"""How the noise is estimated: in turns, each part by its restricted likelihood."""
