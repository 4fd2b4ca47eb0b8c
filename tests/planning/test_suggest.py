"""What directions add to what recordings tell."""

import numpy as np

from pyport.planning.suggest import PRIOR, _Information


def test_directions_that_tell_far_more_than_the_recordings():
    """Two columns that these show alike, ten thousand million times as strong: sigmas stay."""
    recorded = np.diag([1.0, 1.0, 1.0])
    ahead = np.tile([1e10, 1e10, 1e-3], (5, 1))[:, None, :]
    told = _Information(recorded, ahead)
    for n in range(5):
        told.add(n)

    assert np.isfinite(told.gains()).all()
    assert (told.sigmas() <= 1 / np.sqrt(PRIOR) * 1.001).all()
    assert told.sigmas()[2] < 1.001
