"""In initialization mode an output follows just what InitialUnknowns lists (FMI 2.0.4, section 2.2.8)."""

from __future__ import annotations

import pytest

from .support.contract import FMUS
from .support.harness import Fmu


def initial_outputs(fmu: Fmu, **start: float | bool) -> dict[str, float]:
    """The real outputs in initialization mode, with these inputs and parameters."""
    slave = fmu.instantiate()
    try:
        slave.fmi.setupExperiment(startTime=0.0)
        slave.fmi.enterInitializationMode()
        slave.set(**start)
        names = fmu.names("output", "Real")
        return dict(zip(names, slave.reader(names).read()))
    finally:
        slave.fmi.freeInstance()


@pytest.mark.parametrize("name", FMUS)
def test_what_changes_an_output_is_among_its_dependencies(name: str, fmus: dict[str, Fmu]) -> None:
    fmu = fmus[name]
    variables = fmu.description.modelVariables
    dependencies = {
        unknown.variable.name: {known.name for known in unknown.dependencies}
        for unknown in fmu.description.initialUnknowns
        if unknown.variable.causality == "output"
    }
    # Away from rest, with a mass to estimate, so that no dependency hides behind a factor of zero.
    inputs = [v.name for v in variables if v.causality == "input"]
    point = {name: 0.011 * (i + 1) for i, name in enumerate(inputs)}
    point |= {name: 0.3 for name in ("m_hat_0", "J1_hat_0", "J2_hat_0") if name in fmu.variables}
    # Noise and delays need samples; the dead zone counts where its inverse is on.
    point |= {name: 2e-3 for name in ("sample_time",) if name in fmu.variables}
    point |= {name: True for name in ("dead_zone_inverse",) if name in fmu.variables}
    before = initial_outputs(fmu, **point)
    changed = 0
    for known in variables:
        if known.type != "Real" or known.causality not in ("input", "parameter"):
            continue
        value = point.get(known.name, float(known.start))
        after = initial_outputs(fmu, **(point | {known.name: value + 1e-3}))
        for output, value_before in before.items():
            if after[output] != value_before:
                changed += 1
                assert known.name in dependencies[output], f"{output} follows {known.name}"
    assert changed > len(before)
