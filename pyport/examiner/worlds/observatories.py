"""Two observatories whose campaigns are known: the RT32 of 2003-2004, and an array."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from pyport.angles import ARCMIN, ARCSEC, DEG
from pyport.examiner.worlds.campaign import Noise, unix, usual_mount, usual_noise
from pyport.examiner.worlds.case import Case, Hidden, Streams, finish, hide
from pyport.examiner.worlds.earth import EARTH_RADIUS_M, SITES, Site
from pyport.examiner.worlds.faults import Fault
from pyport.examiner.worlds.faults.heavens import left_out
from pyport.examiner.worlds.faults.mount import rt32_edge, rt32_edge_on_the_cable
from pyport.examiner.worlds.faults.surroundings import on_mount
from pyport.examiner.worlds.mount import Mount, Wave
from pyport.examiner.worlds.schedule import (
    Plan,
    Session,
    draw_plan,
    dressed,
    for_antennas,
    rough_place,
    sessions,
)
from pyport.examiner.worlds.sky import sources
from pyport.examiner.worlds.world import Drive, World, believed, observe, unwrapped

_DAY_S = 86400.0

#: Offsets that the RT32's two campaigns measured, by axis.
RT32_ALTITUDE_ROWS, RT32_AZIMUTH_ROWS = 2758, 2857

#: What the RT32's steering left out: it precessed catalogue positions, and that was all.
RT32_LEFT_OUT = (
    "nutation",
    "annual_aberration",
    "diurnal_aberration",
    "ut1",
    "polar_motion",
    "refraction",
)


def rt32_plan(rng: np.random.Generator, rows: int, span_weeks: float | None = None) -> Plan:
    """Return the two campaigns, or one of `span_weeks` from the first day on; one axis a row."""
    spring = [(unix(2003, 3, 15), unix(2003, 6, 13)), (unix(2004, 1, 29), unix(2004, 5, 7))]
    if span_weeks is not None:
        spring = [(spring[0][0], spring[0][0] + span_weeks * 7 * _DAY_S)]
    observing: list[Session] = []
    for first_s, last_s in spring:
        count = max(2, round((last_s - first_s) / (4 * _DAY_S)))
        year = "2003" if first_s < unix(2004, 1, 1) else "2004"
        drawn = sessions(rng, count, first_s, last_s - first_s, (8.0, 20.0))
        observing += [replace(one, name=f"{year}-{one.name[1:]}") for one in drawn]
    plan = draw_plan(
        rng, "rt32", SITES["rt32"], rows, tuple(observing),
        one_axis=True, elevations_deg=(6.0, 85.0), dwell=(4, 20),
    )  # fmt: skip
    azimuth_rows = round(rows * RT32_AZIMUTH_ROWS / (RT32_ALTITUDE_ROWS + RT32_AZIMUTH_ROWS))
    scan_axis = np.where(rng.permutation(rows) < azimuth_rows, "az", "el")
    return replace(plan, labels={**plan.labels, "scan_axis": scan_axis}, cable_middle=np.pi)


def rt32_mount() -> Mount:
    """Return the RT32 as its published table has it, p1 to p7; its azimuth counts from south."""
    return Mount(
        azimuth_zero=-177.4 * ARCSEC,
        elevation_zero=-214.7 * ARCSEC,
        skew=34.0 * ARCSEC,
        beam_left=-47.7 * ARCSEC,
        tilt_north=-5.0 * ARCSEC,
        tilt_east=1.1 * ARCSEC,
        sag_cosine=112.6 * ARCSEC,
    )


#: Amplitudes of the published p8 to p12 [arcsec].
P8, P9, P10, P11, P12 = 41.2, -42.3, 16.3, 15.4, -73.4


def rt32_whole(plan: Plan) -> World:
    """Return the RT32 of the published model, p1 to p12, whose base knows all of them."""
    bare = World(plan, mount=rt32_mount())
    place = believed(bare)
    az_south = unwrapped(plan, place.az) - np.pi
    jumped = np.where(place.el >= rt32_edge_on_the_cable(az_south), ARCSEC, 0.0)
    more = (
        Mount(sag_sine=ARCSEC),
        Mount(waves=(Wave("az", "az", 2, ARCSEC, 0.0),)),
        Mount(waves=(Wave("az", "az", 2, 0.0, ARCSEC),)),
        Mount(pitch=ARCSEC * np.sin(2 * az_south)),
        Mount(beam_down=jumped),
    )
    world = replace(bare, base=(*bare.base, *more))
    return world.with_mount(
        Wave("az", "az", 2, P9 * ARCSEC, P10 * ARCSEC),
        sag_sine=P8 * ARCSEC,
        pitch=P11 * ARCSEC * np.sin(2 * az_south),
        beam_down=P12 * jumped,
    )


def _rt32_faults(world: World) -> list[Fault]:
    """Return p8 to p12 of the published table, as things that the altaz base does not know."""
    place = believed(world)
    above = place.el >= rt32_edge(place.az)
    along = np.arange(0, 360, 10) * DEG
    curve = [
        {"az_deg": float(np.degrees(az)), "el_deg": float(np.degrees(rt32_edge(az)))}
        for az in along
    ]

    def ripple(world: World, size: float) -> World:
        return world.with_mount(Wave("az", "az", 2, P9 * ARCSEC * size, P10 * ARCSEC * size))

    return [
        on_mount("sag_sine", ("el",), {"sag_sine": P8}, pilot=1.0, parameters={"sag_sine": P8}),
        Fault(
            "azimuth_harmonics",
            ripple,
            pilot=1.0,
            where={"axes": ["xel"]},
            facts={"k": 2},
            parameters={"azimuth_harmonic_sine": P9, "azimuth_harmonic_cosine": P10},
        ),
        on_mount(
            "elevation_harmonics",
            ("el",),
            {"pitch": P11 * np.sin(2 * place.az)},
            pilot=1.0,
            facts={"k": 2},
            parameters={"elevation_harmonic_sine": P11, "elevation_harmonic_cosine": 0.0},
        ),
        on_mount(
            "subreflector_jump",
            ("el",),
            {"beam_down": np.where(above, P12, 0.0)},
            pilot=1.0,
            where={"curve": curve},
            parameters={"jump": P12},
        ),
    ]


def rt32(seed: int, rows: int = RT32_ALTITUDE_ROWS + RT32_AZIMUTH_ROWS) -> Case:
    """Make the campaigns that the RT32's published model was fitted to, its p8 to p12 hidden."""
    streams = Streams.of(seed)
    world = World(rt32_plan(streams.plan, rows), mount=rt32_mount())
    # some of the noise is slow, and a tenth of the rows was bad
    sigma = 12.8 * ARCSEC
    noise = Noise(
        sigma, sigma, drift_share=0.2, memory_s=5400.0, outlier_share=0.08, step=3.6 * ARCSEC
    )
    hidden = hide(world, _rt32_faults(world), None, noise)
    return finish(hidden, streams, {"kind": "rt32", "seed": seed}, azimuth_zero="south")


def ablation(
    seed: int,
    omitted: tuple[str, ...],
    span_weeks: float | None,
    rows: int = RT32_ALTITUDE_ROWS + RT32_AZIMUTH_ROWS,
) -> Case:
    """Make the RT32's campaigns with a steering that leaves steps of the reduction out.

    The telescope is the published one as far as the altaz base goes, so that the
    sky alone is what is hidden. Refraction that is left out is that of layers of air.
    """
    streams = Streams.of(seed)
    layered = "refraction" in omitted
    plan = rt32_plan(streams.plan, rows, span_weeks)
    world = World(plan, mount=rt32_mount(), layered=layered)
    faults = [left_out(step, world) for step in omitted]
    sigma = 12.8 * ARCSEC
    noise = Noise(sigma, sigma, drift_share=0.1, memory_s=5400.0, step=3.6 * ARCSEC)
    about: dict[str, Any] = {"kind": "ablation", "seed": seed, "left_out": list(omitted)}
    return finish(hide(world, faults, None, noise), streams, about, azimuth_zero="south")


def array_places(rng: np.random.Generator) -> dict[str, tuple[float, float]]:
    """Draw east and north [m] of 14 antennas in a square and 16 along three arms, to 14 km."""
    places = {f"C{i:02d}": tuple(rng.uniform(-700, 700, 2)) for i in range(14)}
    for arm, toward_deg, count in (("E", 68.0, 5), ("S", 180.0, 5), ("W", 310.0, 6)):
        toward = (toward_deg + rng.uniform(-8, 8)) * DEG
        for i in range(count):
            metres = 1500 + 12000 * (i / (count - 1)) ** 1.3 + rng.uniform(-300, 300)
            places[f"{arm}{i + 1:02d}"] = (metres * np.sin(toward), metres * np.cos(toward))
    return {name: (float(east), float(north)) for name, (east, north) in places.items()}


def gmrt(seed: int, epochs: int = 40, days: int = 4) -> Case:
    """Make elevation scans of one source with an array whose steering knows one place only.

    Every antenna leans and droops in its own way, has its own difference between
    forward and reverse scans, and stands somewhere else; all share a time tag that
    is wrong by another amount each day.
    """
    streams = Streams.of(seed)
    reference = SITES["gmrt"]
    single = _one_source(streams.plan, "Cygnus A", reference, epochs, days)
    places = array_places(streams.plan)
    metres = np.array(list(places.values()))
    north, east = metres[:, 1] / EARTH_RADIUS_M, metres[:, 0] / EARTH_RADIUS_M
    site = reference.moved(north, east / np.cos(reference.latitude))
    names = list(places)
    height = np.full(len(names), reference.height_m)
    plan = for_antennas(single, names, Site(site.latitude, site.longitude, height))

    antenna = np.searchsorted(np.sort(names), plan.labels["antenna"])
    sorted_names = [str(name) for name in np.sort(names)]
    session_names, session = np.unique(plan.labels["session"], return_inverse=True)
    mounts = [usual_mount(streams.mount) for _ in names]
    parts = ("elevation_zero", "tilt_north", "tilt_east", "sag_cosine")
    mount = Mount().plus(**{p: np.array([getattr(m, p) for m in mounts])[antenna] for p in parts})
    play = streams.fault.normal(0, 1.5, len(names)) * ARCMIN
    tag_s = streams.fault.normal(0, 4.0, days)

    bare = World(replace(plan, site=reference), mount=mount)
    full = World(plan, mount=mount, drive=Drive(tag_s=tag_s[session], hysteresis_el=play[antenna]))
    seen, clean = observe(full), observe(bare)
    noise = replace(usual_noise(streams.noise), sigma_y=0.5 * ARCMIN, step=1 * ARCMIN)
    effects = [
        _known(
            "scan_direction",
            {"antenna": dict(zip(sorted_names, play / ARCMIN, strict=True))},
            "arcmin",
        ),
        _known(
            "scan_timing", {"session": dict(zip(session_names.tolist(), tag_s, strict=True))}, "s"
        ),
        _known("site_longitude", {"antenna": {n: places[n][0] for n in sorted_names}}, "m east"),
        _known("site_latitude", {"antenna": {n: places[n][1] for n in sorted_names}}, "m north"),
    ]
    hidden = Hidden(full, seen, noise, (seen.x - clean.x, seen.y - clean.y), effects)
    return finish(hidden, streams, {"kind": "gmrt", "seed": seed})


def _known(effect: str, values: dict[str, dict[str, float]], unit: str) -> dict[str, Any]:
    """Return what the truth file says of a cause whose size differs by label."""
    plain = {label: {name: float(v) for name, v in by.items()} for label, by in values.items()}
    return {
        "effect": effect,
        "class": [effect],
        "unit": unit,
        "values": plain,
        "where": {"axes": ["el"]},
    }


def _one_source(rng: np.random.Generator, name: str, site: Site, epochs: int, days: int) -> Plan:
    """Return elevation scans of one source through its transit, forward and reverse, day by day."""
    number = int(np.flatnonzero(sources().name == name)[0])
    first_s = unix(2003, 5, 31) + np.arange(days) * _DAY_S
    times, labels = [], []
    for day, start_s in enumerate(first_s):
        minutes = start_s + np.arange(0, _DAY_S, 60.0)
        ra, dec = (np.full(len(minutes), v[number]) for v in (sources().ra, sources().dec))
        _, el = rough_place(ra, dec, minutes, site)
        transit_s = minutes[np.argmax(el)]
        times.append(transit_s + np.sort(rng.uniform(-4.5, 4.5, epochs)) * 3600)
        labels += [f"D{day + 1}"] * epochs
    time_s = np.concatenate(times)
    order = np.argsort(time_s)
    plan = dressed(
        rng, "gmrt", site, time_s[order], np.full(len(order), number), np.array(labels)[order],
        sources(),
    )  # fmt: skip
    turns = np.where(np.arange(len(order)) % 2 == 0, 1.0, -1.0)
    scan_axis = np.full(len(order), "el")
    return replace(
        plan,
        scan_direction=turns,
        scan_rate=np.full(len(order), 20 * ARCMIN / 60),
        labels={**plan.labels, "scan_axis": scan_axis},
    )
