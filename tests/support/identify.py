"""Eigenvalues of an FMU from outside: its pulse responses determine them (eigensystem realisation algorithm).

A slave that steps a linear system exactly is, at its communication points, x[n+1] = A x[n], y = C x. Hankel matrices
of the responses give the eigenvalues of A to round-off when the outputs see every state. Nothing of the FMU's inside is
used.
"""

from __future__ import annotations

import numpy as np

from .contract import MEASURED
from .harness import CoSimulation, Fmu

# Sizes of the signals, so that no output drowns in the round-off of another (J. Juang, R. Pappa, 1985, scale likewise).
SCALES = {"rad": 0.05, "rad/s": 1.0, "m": 0.01, "m/s": 0.1, "N.m": 0.1, "N": 1.0, "N/s": 300.0}


def pulse_responses(plant: Fmu, step: float, samples: int, **parameters: float) -> np.ndarray:
    """Responses [sample, output, input] of the measured outputs to a pulse of one step of each command, from rest."""
    pulses = {"tau1_cmd": 1.0, "tau2_cmd": 1.0, "u_cmd": 1.0}
    responses = []
    for pulsed, size in pulses.items():
        with CoSimulation([plant]) as alone:
            alone.set(actuator_model="ideal", **parameters)
            result = alone.run(
                samples * step,
                step,
                record=tuple(MEASURED),
                drive=lambda t, pulsed=pulsed, size=size: {name: size * (t == 0 and name == pulsed) for name in pulses},
            )
        # The state at rest is zero but for y_object = L/2.
        responses.append([(result[name][1:] - result[name][0]) / SCALES[unit] for name, unit in MEASURED.items()])
    return np.transpose(np.array(responses), (2, 1, 0))


def eigenvalues(responses: np.ndarray, rows: int = 20) -> np.ndarray:
    """Eigenvalues of the one-step matrix A. The rank of the Hankel matrix is taken where its singular values drop."""
    columns = len(responses) - rows
    hankel = np.block([[responses[i + j] for j in range(columns)] for i in range(rows)])
    shifted = np.block([[responses[i + j + 1] for j in range(columns)] for i in range(rows)])
    left, sizes, right = np.linalg.svd(hankel, full_matrices=False)
    rank = int(np.sum(sizes > 1e-11 * sizes[0]))
    root = np.sqrt(sizes[:rank])
    return np.linalg.eigvals((left[:, :rank].T @ shifted @ right[:rank].T) / np.outer(root, root))


def nearest(found: np.ndarray, expected: complex, step: float) -> complex:
    """The eigenvalue in 1/s that belongs to an expected one: the nearest after one step."""
    z = np.exp(expected * step)
    return complex(expected + np.log(found[np.argmin(np.abs(found - z))] / z) / step)
