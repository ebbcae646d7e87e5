"""The exact solution of the linear dual-arm model, without any discretisation in space or time.

Each arm is replaced by its dynamic stiffness (`beam`), the hubs, the object, the uncertainties and a linear feedback
close the loop (`system`); the zeros of the resulting characteristic function are the eigenvalues (`roots`), and its
residues give time responses (`response`). `python -m tests.oracle` writes the values that `dualarm verify` and the tests read.

Independent of the Rust code by construction: written from the equations (2)-(14) of the paper, in another language, by
another method.
"""

from pathlib import Path

# Data of the tool: it compares with them, too.
DATA = Path(__file__).resolve().parents[2] / "dualarm" / "data" / "verify"
