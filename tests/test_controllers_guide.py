"""docs/controllers.md is true: what its tables of measurements say is what the tool gives."""

from __future__ import annotations

import json
import re

import pytest

from .support.paths import ROOT, description
from .support.tool import dualarm

GUIDE = (ROOT / "docs" / "controllers.md").read_text(encoding="utf-8")
NETWORKS_OFF = ("a1=0", "a31=0", "a32=0")
ALL_OFF = (*NETWORKS_OFF, *(f"{name}=0" for name in ("m_hat_0", "b1", "gamma1", "g11", "g12", "zeta11", "zeta12")))


def table(name: str) -> list[list[str]]:
    """The cells of the table between the comments of that name, without its head."""
    lines = GUIDE.split(f"<!-- {name}:")[1].split(f"<!-- end of {name}")[0].splitlines()
    rows = [[cell.strip().strip("`") for cell in line.strip("|").split("|")] for line in lines if line.startswith("|")]
    return rows[2:]


def measured(controller: str, stop: float, settings: tuple[str, ...]) -> tuple[str, str]:
    """Settling time of the later contact force and the larger steady error, of every step, as the tool's tables show them."""
    flags = [flag for setting in settings for flag in ("--set", setting)]
    done = dualarm("simulate", "--controller", controller, "--stop", str(stop), *flags, "--quiet", "--json")
    assert done.returncode == 0, done.stderr
    forces = [json.loads(done.stdout)["metrics"][f"contact_force{arm}"] for arm in (1, 2)]
    times = [force["settling_2"] for force in forces]
    error = max(abs(force["steady_error"]) for force in forces)
    return ("never" if None in times else f"{max(times):.3f} s"), f"{1e3 * error:.2f} mN"


def same(shown: str, got: str) -> bool:
    """Equal to one in the last digit: compilers and processors round differently."""
    if "never" in (shown, got):
        return shown == got
    (number, unit), (other, _) = shown.split(), got.split()
    return abs(float(number) - float(other)) < 1.5 * (1e-3 if unit == "s" else 1e-2)


@pytest.mark.parametrize("row", table("ablation"), ids=lambda row: row[1] or "nominal")
def test_ablation(row: list[str]) -> None:
    _, setting, *shown = row
    case = (setting,) if setting else ()
    for cell, off in zip(shown, ((), NETWORKS_OFF, ALL_OFF)):
        settled, error = measured("nabfc", 6, (*case, *off))
        assert same(cell.split(", ")[0], settled), (row[0], off, settled)
        assert same(cell.split(", ")[1], error), (row[0], off, error)


@pytest.mark.parametrize("row", table("raw"), ids=lambda row: row[0])
def test_dead_zones(row: list[str]) -> None:
    controller, compensated, raw, error = row
    assert same(compensated, measured(controller, 8, ())[0])
    settled, got = measured(controller, 8, ("actuator_model=raw",))
    assert same(raw, settled)
    assert same(error, got)


def test_gains_shown_are_the_defaults() -> None:
    """The paper's of PD and PDS, ours of NABFC: `name` number, wherever that stands."""
    pd, rest = GUIDE.split("\n* PD: ")[1].split("\n* PDS: ")
    pds, rest = rest.split("\n", 1)
    nabfc = rest.split("## NABFC: our choices")[1].split("\n* ")[0]
    for fmu, text, least in (("PdController", pd, 6), ("PdsController", pds, 8), ("NabfcController", nabfc, 29)):
        shown = re.findall(r"`(\w+)` (\d+(?:\.\d+)?)", text)
        assert len(shown) >= least
        for name, value in shown:
            (variable,) = description(fmu).xpath(f"//ScalarVariable[@name='{name}']/*")
            assert float(variable.get("start")) == float(value), name
