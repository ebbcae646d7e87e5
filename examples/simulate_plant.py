"""One FMU in FMPy: a torque moves the grasped object aside and brings it to rest again.

    python examples/simulate_plant.py
    python simulate_plant.py --plant ~/Downloads/DualArmPlant.fmu      # a copy of this file, anywhere

Hub 1 gets +0.05 N.m for 0.1 s and -0.05 N.m for another 0.1 s; hub 2 and the object are not driven. All that moves the
object is the bending of the two arms, which goes on a little after the torque has ended.
"""

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from fmpy import simulate_fmu

PLANT = Path(__file__).resolve().parent.parent / "dist" / "DualArmPlant.fmu"

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--plant", metavar="FILE", default=PLANT, help="the FMU [default: that in the repository's dist]")
parser.add_argument("--save", metavar="FILE", help="write the plot to FILE instead of opening a window")
arguments = parser.parse_args()
save = arguments.save

# The input over time; two rows of one time are a jump. Inputs that are not listed stay at their start value, zero, and
# FMPy prints a warning for each.
torque = np.array(
    [(0.0, 0.05), (0.1, 0.05), (0.1, -0.05), (0.2, -0.05), (0.2, 0.0), (1.0, 0.0)],
    dtype=[("time", float), ("tau1_cmd", float)],
)
result = simulate_fmu(
    str(Path(arguments.plant).expanduser()),
    stop_time=1.0,
    # The plant solves every step exactly, whatever its size: this is the resolution of the plot, not an accuracy.
    output_interval=1e-3,
    start_values={"M": 0.3},  # any parameter by name; an enumeration by the number of its item, as "actuator_model": 1
    input=torque,
    output=["tau1", "theta1", "theta2", "contact_force1", "contact_force2", "tip_deflection1", "tip_deflection2"],
)

print(f"hub angles at 1 s: {result['theta1'][-1]:.6f} and {result['theta2'][-1]:.6f} rad")
print(f"contact forces at 1 s: {result['contact_force1'][-1]:.1e} and {result['contact_force2'][-1]:.1e} N")

figure, panels = plt.subplots(4, sharex=True, figsize=(7, 8), layout="constrained")
panels[0].plot(result["time"], result["tau1"], color="black")
panels[0].set_ylabel("torque on\nhub 1 [N·m]")
for panel, signal, factor, label in (
    (panels[1], "theta", np.degrees(1), "hub angle [°]"),
    (panels[2], "tip_deflection", 1e3, "tip deflection\n[mm]"),
    (panels[3], "contact_force", 1, "contact force\n[N]"),
):
    for arm, style in ((1, "-"), (2, "--")):
        panel.plot(result["time"], factor * result[f"{signal}{arm}"], style, label=f"arm {arm}")
    panel.set_ylabel(label)
panels[1].legend()
panels[-1].set_xlabel("time [s]")
for panel in panels:
    panel.grid(alpha=0.3)
figure.align_ylabels()
if save:
    figure.savefig(save, dpi=150)
else:
    plt.show()
