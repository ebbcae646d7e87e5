"""One plant, three controllers: only the file name changes.

python examples/swap_controller.py
"""

import argparse

import matplotlib.pyplot as plt
from grasp import Grasp, find_dist, settling_time

FORCES = ("contact_force1", "contact_force2")

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--save", metavar="FILE", help="write the plot to FILE instead of opening a window")
parser.add_argument("--dist", metavar="FOLDER", help="where the FMUs are")
arguments = parser.parse_args()
save, dist = arguments.save, find_dist(arguments.dist)

figure, panels = plt.subplots(2, sharex=True, sharey=True, figsize=(7, 6), layout="constrained")
for name in ("NabfcController", "PdsController", "PdController"):
    grasp = Grasp(name, dist)
    # At 0.1 ms; the hub gain of PdController is stable up to 0.26 ms only, NabfcController would do with 1 ms.
    result = grasp.run(5.0, *FORCES)
    grasp.close()
    times = [settling_time(result["time"], result[force], 0.5) for force in FORCES]
    print(f"{name:<16} settles within 2 % in {times[0]:.3f} s (arm 1) and {times[1]:.3f} s (arm 2)")
    for panel, force in zip(panels, FORCES):
        panel.plot(result["time"], result[force], label=name)

for arm, panel in enumerate(panels, 1):
    panel.axhspan(0.49, 0.51, color="gray", alpha=0.25)
    panel.set_ylabel(f"contact force\nof arm {arm} [N]")
    panel.grid(alpha=0.3)
panels[0].legend(loc="lower right")
panels[1].set_xlabel("time [s]")
if save:
    figure.savefig(save, dpi=150)
else:
    plt.show()
