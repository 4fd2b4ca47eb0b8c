"""The order in which effects were chosen is no part of an answer."""

import pytest
from diagnosis.made import recordings

from pyport.diagnosis.case import Chosen
from pyport.diagnosis.preparing import prepare
from pyport.diagnosis.searching.confirming import _noise_alike
from pyport.diagnosis.weighing import noise
from pyport.formats.models import load


@pytest.mark.parametrize("alike", [False, True])
def test_the_noise_is_the_same_whoever_of_the_chosen_comes_first(alike):
    """To the last digit, for threads that ask for it remember the answer of the first."""
    found = []
    for way in (1, -1):
        problem = prepare(recordings(200, 3), load("altaz"), seed=1)
        ids = ("azimuth_eccentricity", "elevation_scale", "backlash_azimuth")
        some = [one for one in problem.candidates if one.effect.id in ids][:3]
        chosen = [Chosen(one, "all") for one in some][::way]
        if alike:
            found.append(_noise_alike(problem, chosen, chosen).noises)
        else:
            found.append(noise(problem, chosen, searching=False).noises)

    assert len(some) > 1
    assert found[0] == found[1]
