"""`pyport dev`: what those who work on the program need, and those who check it."""

from __future__ import annotations

from pyport.cli.manners import Lazy

command = Lazy(
    "dev",
    "pyport.cli.dev",
    {
        "acceptance": "Measure what is promised of a diagnosis, on real and simulated recordings.",
        "calibrate": "Count false alarms against each threshold, and coverage, in simulated noise.",
        "challenge": "Write recordings of hidden causes for others to solve; score their answers.",
        "cosines": "Measure how much of each unknown form the best term can take.",
        "effects": "List the physical effects that a diagnosis may name, and what each one needs.",
        "efficiency": "Hold detections and names against what an ideal observer could detect.",
        "field-system": "Compare with the VLBI Field System's own outputs.",
        "imports": "Print which part of the program imports which, and what climbs.",
        "keys": "List the keys of report.json, with their types and meanings.",
        "mounts": "Count what is found, and what is not there, on German, fork and X-Y mounts.",
        "nights": "Count false alarms of the watch, and measure delays, on simulated nights.",
        "nulls": "Count false claims, and how often sigmas hold, in simulated noise.",
        "prove": "Seal cases, answer them, open them: a proof in three commits; verify one.",
        "real": "Run fit and diagnose on public recordings, beside what was published of them.",
        "reduction": "Take nutation, aberration, UT1, ... out of offsets; print their sizes.",
        "replays": "Replay public recordings to the watch: what is raised, and what is known.",
        "thresholds": "List the numbers that decide what a diagnosis says, and why each is so.",
        "trials": "Put causes into simulated recordings; check whether a diagnosis finds them.",
        "verify": "Check that all files of a diagnosis are of one run.",
    },
    shared={
        "simulated": "calibrate cosines efficiency mounts nights nulls",
        "recorded": "acceptance field-system real reduction replays verify",
        "listed": "effects keys thresholds",
        "proof": "challenge prove",
    },
    help="Check the program: its catalogue, its promises, its answers to simulated recordings.",
)
