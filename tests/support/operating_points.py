"""Where the FMUs are looked at: sizes of their inputs in a grasp, and the paper's law with and without its networks."""

from __future__ import annotations

from .contract import PAPER

# Sizes of the signals in a grasp: random operating points are drawn from +- these.
INPUT_SIZES = {
    **{"tau1_cmd": 0.3, "tau2_cmd": 0.3, "u_cmd": 0.2, "delta_f1": 0.05, "delta_f2": 0.05, "delta_F": 0.05},
    **{"theta1": 0.05, "theta2": 0.05, "theta1_dot": 0.5, "theta2_dot": 0.5, "y_object": 0.05, "y_object_dot": 0.1},
    **{"root_moment1": 0.1, "root_moment2": 0.1, "tip_shear1": 0.5, "tip_shear2": 0.5},
    **{"tip_shear1_dot": 10.0, "tip_shear2_dot": 10.0, "lambda1_ref": 0.5, "theta1_ref": 0.05},
    **{"root_moment1_dot": 1.0, "root_moment2_dot": 1.0},
}
NETWORKS_OFF = {**PAPER, "a1": 0.0, "a31": 0.0, "a32": 0.0}
NETWORKS_ON = {
    **PAPER,
    **{"a1": 5.0, "a2": 0.1, "a31": 0.5, "a41": 0.1, "a32": 0.5, "a42": 0.1},
    **{"m_hat_0": 0.05, "J1_hat_0": 0.002, "J2_hat_0": 0.003},
}
