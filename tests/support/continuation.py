"""Something to continue: an FMU under changing inputs, and a process of its own that goes on from a saved state.

    python -m tests.support.continuation NabfcController.fmu state.bin 50

prints what the FMU would have done over the next 50 steps, one line of outputs per step.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

from .capabilities import from_bytes, input_slopes
from .harness import Fmu, Slave

STEP = 1e-4

# Start values under which everything is in use: actuators at their limits and in their dead zones, networks, filter.
SETTINGS: dict[str, dict[str, float | str]] = {
    "DualArmPlant": {"actuator_model": "raw", "EI2": 0.2, "order": 10, "kelvin_voigt": 1e-4, "theta1_0": 0.02},
    "PdController": {"EI2": 0.2, "kp": 12.0},
    "PdsController": {"EI2": 0.2, "ks2": 8.0},
    "NabfcController": {
        **{"EI2": 0.2, "a1": 5.0, "a2": 0.1, "a31": 0.5, "a41": 0.1, "a32": 0.4, "a42": 0.2},
        **{"rbf_nodes_posture": 3, "m_hat_0": 0.05, "J1_hat_0": 0.002, "shear_rate_bandwidth": 300.0},
        "r_learner": "networks",
    },
    "GraspInstruments": {
        **{"sample_time": 3e-4, "theta1_noise": 0.01, "theta2_lsb": 1e-3, "y_object_bandwidth": 300.0, "seed": 5},
        **{"tip_shear1_delay": 1e-3, "tip_shear2_noise": 0.1, "tip_shear2_sample_time": 1e-4, "theta1_dot_bias": 0.2},
    },
    "GraspActuators": {
        **{"sample_time": 3e-4, "dead_zone_inverse": True, "m_r1": 0.2, "k_l2": 0.7},
        **{"tau1_cmd_delay": 1e-3, "tau2_cmd_rate_limit": 50.0, "u_cmd_bandwidth": 200.0},
    },
}
# Amplitudes of the inputs, by the beginning of their names; commands beyond the actuators' limits.
AMPLITUDES = {
    **{
        "tau": 3.0,
        "u_cmd": 0.5,
        "delta": 0.02,
        "theta1_dot": 0.5,
        "theta2_dot": 0.5,
        "theta": 0.05,
        "y_object_dot": 0.1,
    },
    **{"y_object": 0.02, "root_moment1_dot": 1.0, "root_moment2_dot": 1.0, "root_moment": 0.1, "tip_shear1_dot": 10.0, "tip_shear2_dot": 10.0, "tip_shear": 0.5},
    **{"lambda1_ref": 0.5},
}


def inputs_at(fmu: Fmu, i: int) -> dict[str, float]:
    """All inputs at step i: sines at different rates."""
    names = fmu.names("input", "Real")
    sizes = (next(size for start, size in AMPLITUDES.items() if name.startswith(start)) for name in names)
    return {name: size * math.sin(1.0 + k + (0.1 + 0.01 * k) * i) for k, (name, size) in enumerate(zip(names, sizes))}


def advance(slave: Slave, first: int, count: int) -> list[list[float]]:
    """Steps from number `first` on, every other one with ramped inputs; the real outputs after each."""
    names, rows = slave.fmu.names("input", "Real"), []
    inputs, slopes = slave.writer(names), input_slopes(slave, names)
    outputs = slave.reader(slave.fmu.names("output", "Real"))
    slopes.values[:] = [0.3 / (1 + k) for k in range(len(names))]
    for i in range(first, first + count):
        inputs.values[:] = list(inputs_at(slave.fmu, i).values())
        inputs.write()
        if i % 2:
            slopes.write()
        slave.step(i * STEP, STEP, 0)
        rows.append(outputs.read())
    return rows


def running(fmu: Fmu, steps: int) -> Slave:
    """An instance in the middle of a run."""
    slave = fmu.instantiate(logging=True)
    slave.set(**SETTINGS[fmu.name])
    slave.start()
    advance(slave, 0, steps)
    return slave


def main() -> None:
    """Continues from a blob whose number of steps so far is its clock's."""
    path, blob, first, count = sys.argv[1:]
    fmu = Fmu(path)
    try:
        with fmu.instantiate("elsewhere") as slave:
            from_bytes(slave, Path(blob).read_bytes())
            for row in advance(slave, int(first), int(count)):
                print(*map(float.hex, row))
    finally:
        fmu.close()


if __name__ == "__main__":
    main()
