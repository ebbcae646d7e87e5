"""Writes `dualarm/data/verify/values.json`: `python -m tests.oracle [-o FILE]` (a few minutes)."""

from __future__ import annotations

import argparse
import json
import re
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

import mpmath
from mpmath import mp, mpf

from . import DATA
from .cases import LOOPS, PLANTS, STEPS, TARGET_THETA1_DEG, Loop, Step
from .response import ResidueSum, eigenvalue_bands, invert
from .system import OUTPUTS

DIGITS = 30
LISTED_PAIRS = 6
SUMMED_PAIRS = 32


def main() -> None:
    """Computes everything and writes one file."""
    parser = argparse.ArgumentParser(prog="python -m tests.oracle", description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=DATA / "values.json")
    output = parser.parse_args().output
    mp.dps = DIGITS
    start = time.perf_counter()
    document = {
        "made_by": "python -m tests.oracle",
        "method": "dynamic stiffness of Euler-Bernoulli arms; eigenvalues by the argument principle and secant steps; "
        "responses as residue sums, or by Talbot's inversion where kelvin_voigt > 0; y is y_M - L/2",
        "precision_digits": DIGITS,
        "mpmath": mpmath.__version__,
        "plants": {name: asdict(plant) for name, plant in PLANTS.items()},
        "eigenvalues": {name: listed_eigenvalues(loop) for name, loop in LOOPS.items()},
        "steps": {name: step_response(step) for name, step in STEPS.items()},
    }
    output.write_text(compact(document), encoding="utf-8")
    print(f"{output.name} written after {time.perf_counter() - start:.0f} s")


def listed_eigenvalues(loop: Loop) -> dict[str, Any]:
    """The eigenvalues with Im >= 0 as [real, imaginary], band by band; those at 0 as their number."""
    bands = eigenvalue_bands(loop.system(), LISTED_PAIRS, loop.zero_multiplicity)
    spectrum = [s for band in bands for s in band]
    if not loop.uncertainties and not loop.system().plant.kelvin_voigt and loop.feedback == "none":
        spectrum = [mpmath.mpc(0, s.imag) for s in spectrum]  # conservative: what is left in Re is round-off
    return {
        "plant": loop.plant,
        "feedback": loop.feedback,
        "uncertainties": loop.uncertainties,
        "at_zero": loop.zero_multiplicity,
        "values": [[float(s.real), float(s.imag)] for s in spectrum],
    }


def step_response(step: Step) -> dict[str, Any]:
    """Values at the given times, with the error of each and what modes that a coarse model lacks contribute at most."""
    loop = LOOPS[step.loop]
    head = {"loop": step.loop, "input": step.input, "amplitude": float(step.amplitude)}
    if step.input == "target":
        head |= {"lambda1": float(step.amplitude), "theta1_deg": float(TARGET_THETA1_DEG)}
    if loop.system().plant.kelvin_voigt:
        return {**head, "at": [by_talbot(step, t) for t in step.times]}
    system = loop.system()
    bands = eigenvalue_bands(system, SUMMED_PAIRS, loop.zero_multiplicity)
    return {**head, "at": by_residues(step, ResidueSum(system, step.loads(system), bands))}


def by_talbot(step: Step, t: str) -> dict[str, Any]:
    """Values by Talbot's contour; the error is its change when the number of nodes grows by half."""
    system = LOOPS[step.loop].system()
    outputs = {}
    for name in OUTPUTS:
        coarse, fine = (invert(system, step.loads(system), name, mpf(t), "talbot", degree) for degree in (60, 90))
        outputs[name] = {"value": float(fine), "error": rounded(abs(fine - coarse))}
    return {"t": float(t), "outputs": outputs}


def by_residues(step: Step, response: ResidueSum) -> list[dict[str, Any]]:
    """Values as residue sums; the error assumes that the bands left out decay like the square of their number.

    `beyond` bounds what all bands after number 0, 1, 2, ... contribute: what a model with so few modes must miss.
    """
    rows = []
    for t in step.times:
        values, outputs = response.at(mpf(t)), {}
        for name in OUTPUTS:
            bounds = response.band_bounds(name, mpf(t))
            outputs[name] = {
                "value": float(values[name]),
                "error": rounded(bounds[-1] * len(bounds)),
                "beyond": [rounded(mp.fsum(bounds[n + 1 :])) for n in range(LISTED_PAIRS + 1)],
            }
        rows.append({"t": float(t), "outputs": outputs})
    return rows


def rounded(value: Any) -> float:
    """A bound needs two digits."""
    return float(f"{float(value):.1e}")


def compact(document: dict[str, Any]) -> str:
    """JSON with one line per innermost object or list of numbers."""
    text = json.dumps(document, indent=1)
    text = re.sub(r"\[[^\[\]{}]*\]", lambda found: re.sub(r"\s+", " ", found[0]), text)
    text = re.sub(r"\{[^{}]*\}", lambda found: re.sub(r"\s+", " ", found[0]), text)
    return text + "\n"


if __name__ == "__main__":
    main()
