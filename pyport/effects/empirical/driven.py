"""Driven terms, which follow a recorded condition; shapes of models without a cause."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from pyport.angles import Array
from pyport.effects.base import (
    AXES,
    SKY,
    Basis,
    Circumstances,
    Coefficient,
    Effect,
    MissingColumn,
    stack,
)
from pyport.effects.empirical.conditions import OF_AIR, tried
from pyport.effects.empirical.drivers import OF_TEMPERATURE, Driver, driver_of
from pyport.effects.sky.atmosphere import refraction
from pyport.effects.telescope.geometry import collimation, elevation_zero, sag_cosine, tilt

_GREVE = "Greve & Bremer 2010, Thermal Design and Thermal Behaviour of Radio Telescopes"

_NEEDS = "temperature_c or wind_speed_m_s or humidity_pct or pressure_hpa or sun_el_deg or time_utc"

#: The terms: what they do for one unit, what their coefficients are called, and in words.
_TERMS: dict[str, tuple[Basis, tuple[str, ...], str]] = {
    "tilt": (tilt, ("tilt_north", "tilt_east"), "the azimuth axis leans"),
    "sag_cosine": (sag_cosine, ("sag_cosine",), "the structure sags"),
    "elevation_zero": (elevation_zero, ("elevation_zero",), "the elevation zero moves"),
    "collimation": (collimation, ("collimation",), "the collimation changes"),
    "refraction": (refraction, ("refraction",), "the correction for refraction is off"),
}


def driven(term: str, driver: Driver) -> Effect:
    """Return a term of the mount times a condition, reported per unit of the condition."""
    shape, names, words = _TERMS[term]

    def basis(at: Circumstances) -> tuple[Array, Array]:
        x, y = shape(at)
        each = [
            (x[:, k] * one, y[:, k] * one) for one in driver.values(at) for k in range(x.shape[1])
        ]
        return stack(at, *each)

    unit = f"arcsec/{driver.unit}" if driver.unit else "arcsec"
    return Effect(
        "driven_term",
        f"{words} {driver.changes or f'as {driver.name} changes'}",
        _GREVE,
        tuple(Coefficient(f"{name}{label}", unit) for label in driver.labels for name in names),
        basis,
        variant=f"{term} follows {driver.name}",
        profile=_driven_terms,
        acts_in=SKY if term in ("sag_cosine", OF_AIR) else AXES,
        pattern=f"{term.replace('_', ' ')} follows {driver.name}",
        needs=(_NEEDS,),
        formula=(
            "a term of the mount times (c - c0), c a recorded condition",
            "the same term along elevation",
        ),
        driver=driver.follows,
        change_of=term,
        looks_back=driver.looks_back,
        member={"term": term, "follows": driver.name, **driver.stated},
        make=_made,
    )


def _made(term: str, follows: str, **more: Any) -> Effect:  # noqa: ANN401 - what a file may hold
    """Return the term that a file tells."""
    return driven(term, driver_of(follows, **more))


def _driven_terms(at: Circumstances) -> tuple[Effect, ...]:
    found = tuple(driven(term, one) for one in tried(at) for term in one.terms)
    if not found:
        raise MissingColumn(_NEEDS)
    return found


def hour_angle_wave(at: Circumstances) -> tuple[Array, Array]:
    """Return cos h and sin h along elevation."""
    hour_angle = at.column("hour_angle")
    return stack(at, (0, np.cos(hour_angle)), (0, np.sin(hour_angle)))


EFFECTS = (
    replace(
        driven("tilt", OF_TEMPERATURE), sentence="a term of the mount follows a recorded condition"
    ),
    Effect(
        "hour_angle_wave",
        "the elevation offset follows a cosine of hour angle",
        "Lal, Ishwara-Chandra & Rao, The GMRT Antenna Pointing II (2003), section 4",
        (Coefficient("hour_angle_cosine"), Coefficient("hour_angle_sine")),
        hour_angle_wave,
        physical=False,
        acts_in=SKY,
        needs=("hour_angle_h",),
        formula=("", "c cos H + s sin H"),
    ),
)
