"""Save, try, restore: a firm grasp is pushed, and the best of several hub gains is found by going back in time.

    python examples/state_rollback.py

FMUs can save their whole state (fmi2GetFMUstate), return to it (fmi2SetFMUstate), and turn it into bytes that another
instance, in another process or next week, takes up (fmi2SerializeFMUstate, fmi2DeSerializeFMUstate).
"""

import argparse

import matplotlib.pyplot as plt
import numpy as np
from grasp import Grasp, find_dist

GOAL, PUSH = 0.5, 0.1  # wanted contact force [N]; force that pushes the object [N]
GAINS = (40.0, 200.0, 1000.0, 5000.0, 25000.0)  # kp [N/m] that are tried

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--save", metavar="FILE", help="write the plot to FILE instead of opening a window")
parser.add_argument("--dist", metavar="FOLDER", help="where the FMUs are")
arguments = parser.parse_args()
save, dist = arguments.save, find_dist(arguments.dist)


def pushed(grasp: Grasp, gain: float) -> dict[str, np.ndarray]:
    """What a push of one second does when the controller has this gain."""
    grasp.controller.set("kp", gain)  # tunable: may change while the FMU runs
    grasp.plant.set("delta_F", PUSH)
    return grasp.run(1.0, "contact_force1")


grasp = Grasp("PdsController", dist)
before = grasp.run(3.0, "contact_force1")
components = (grasp.plant, grasp.controller)
saved_time = grasp.time
saved = [component.fmu.getFMUstate() for component in components]

# Try: every gain starts from the same instant.
tries, error = {}, {}
for gain in GAINS:
    for component, state in zip(components, saved):
        component.fmu.setFMUstate(state)
    grasp.time = saved_time
    tries[gain] = pushed(grasp, gain)
    error[gain] = np.sqrt(np.mean((tries[gain]["contact_force1"] - GOAL) ** 2))
    print(f"kp = {gain:5.0f} N/m: the force is {1e3 * error[gain]:.1f} mN off its target (root mean square)")
best = min(error, key=error.get)
print(f"best: kp = {best:.0f} N/m")

# As bytes, into a new pair of instances: they go on exactly as the old ones did.
copies = [component.fmu.serializeFMUstate(state) for component, state in zip(components, saved)]
for component, state in zip(components, saved):
    component.fmu.freeFMUstate(state)
twin = Grasp("PdsController", dist)
for component, data in zip((twin.plant, twin.controller), copies):
    component.fmu.setFMUstate(component.fmu.deSerializeFMUstate(data))
twin.time = saved_time
same = np.array_equal(pushed(twin, best)["contact_force1"], tries[best]["contact_force1"])
print(
    f"from {sum(map(len, copies))} bytes, a new pair of instances gives {'the same bits' if same else 'other values'}"
)
grasp.close()
twin.close()

figure, panel = plt.subplots(figsize=(7, 4), layout="constrained")
recent = before["time"] > saved_time - 0.3
panel.plot(before["time"][recent], before["contact_force1"][recent], color="black")
for gain, result in tries.items():
    panel.plot(result["time"], result["contact_force1"], label=f"kp = {gain:.0f} N/m")
panel.axvline(saved_time, color="black", linewidth=0.8, linestyle=":")
panel.annotate(
    "state saved,\npush begins", (saved_time, panel.get_ylim()[0]), (-6, 6), textcoords="offset points", ha="right"
)
panel.set(xlabel="time [s]", ylabel="contact force of arm 1 [N]")
panel.legend()
panel.grid(alpha=0.3)
if save:
    figure.savefig(save, dpi=150)
else:
    plt.show()
