"""The end of the demonstration: a night, its alarm, a picture."""

import pytest

from pyport.cli import demo


@pytest.mark.slow
def test_a_night_is_watched_and_drawn(tmp_path):
    """What an observer reads names the tilt; the picture is one."""
    told = demo._night(tmp_path / "night.png")

    assert "alarm 1 raised" in told[0]
    assert any("the azimuth axis leans" in line for line in told)
    assert (tmp_path / "night.png").read_bytes().startswith(b"\x89PNG")
