"""Your own control law, in Python, against the plant FMU.

    python examples/own_controller.py

`law` is all there is to change. Here it cancels what the arms do to hubs and object (root moments and tip shears, which
strain gauges show); what is left are three rigid bodies of known inertia, and each becomes a critically damped oscillator
about its target. No contact force is measured: the targets are the angles and the position at which the bent arms press
with the wanted force.
"""

import argparse

import matplotlib.pyplot as plt
import numpy as np
from grasp import PLANT, Component, find_dist, settling_time

EI, LENGTH, SIDE = 0.115, 0.2, 0.1  # bending stiffness [N.m2], length of an arm [m], width of the object [m]
HUB_INERTIA, MASS = 0.0073, 0.5  # [kg.m2], [kg]: object and both tips
FORCE, ANGLE = 0.5, np.radians(3)  # wanted contact force [N], wanted angle of hub 1 [rad]
RATE = 30.0  # double pole of each of the three loops [1/s]; more makes the actuators saturate

# Static equilibrium, eq. (16): the tip of arm 1 is pushed back by FORCE l^3/(3 EI), that of arm 2 to the other side.
THETA = (ANGLE, ANGLE - 2 * FORCE * LENGTH**2 / (3 * EI))
POSITION = LENGTH * ANGLE - FORCE * LENGTH**3 / (3 * EI) + SIDE / 2

MEASURED = (
    *("theta1", "theta2", "theta1_dot", "theta2_dot", "y_object", "y_object_dot"),
    *("root_moment1", "root_moment2", "tip_shear1", "tip_shear2"),
)


def law(theta1, theta2, theta1_dot, theta2_dot, y, y_dot, moment1, moment2, shear1, shear2):
    """Hub torques [N.m] and force on the object [N] from the measured signals."""

    def servo(inertia, error, speed):
        return -inertia * (RATE**2 * error + 2 * RATE * speed)

    return (
        moment1 + servo(HUB_INERTIA, theta1 - THETA[0], theta1_dot),
        moment2 + servo(HUB_INERTIA, theta2 - THETA[1], theta2_dot),
        shear1 + shear2 + servo(MASS, y - POSITION, y_dot),
    )


def main() -> None:
    """Runs the law against the plant, prints when the forces have settled and plots it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--save", metavar="FILE", help="write the plot to FILE instead of opening a window")
    parser.add_argument("--dist", metavar="FOLDER", help="where the FMUs are")
    arguments = parser.parse_args()
    save = arguments.save

    plant = Component(find_dist(arguments.dist) / PLANT)
    plant.fmu.setupExperiment(startTime=0.0)
    plant.fmu.enterInitializationMode()
    plant.fmu.exitInitializationMode()
    inputs = [plant.variables[name].valueReference for name in ("tau1_cmd", "tau2_cmd", "u_cmd")]
    shown = ("contact_force1", "contact_force2", "theta1", "theta2")

    step, rows = 1e-3, []  # the plant is exact at any step: 1 ms is the sampling time of the law
    for i in range(1000):
        plant.fmu.setReal(inputs, law(*plant.get(*MEASURED)))
        rows.append([i * step, *plant.get(*shown)])
        plant.fmu.doStep(i * step, step)
    time, *signals = np.array(rows).T
    plant.close()

    for arm, force in enumerate(signals[:2], 1):
        settled = settling_time(time, force, FORCE)
        print(f"contact force {arm}: {force[-1]:.4f} N at the end, within 2 % from {settled:.3f} s on")

    figure, (upper, lower) = plt.subplots(2, sharex=True, figsize=(7, 6), layout="constrained")
    upper.axhspan(0.98 * FORCE, 1.02 * FORCE, color="gray", alpha=0.25, label="target ± 2 %")
    for arm in (0, 1):
        upper.plot(time, signals[arm], ("-", "--")[arm], label=f"arm {arm + 1}")
        (line,) = lower.plot(time, np.degrees(signals[2 + arm]), ("-", "--")[arm], label=f"hub {arm + 1}")
        lower.axhline(np.degrees(THETA[arm]), color=line.get_color(), linewidth=0.8, alpha=0.5)
    upper.set_ylabel("contact force [N]")
    lower.set(xlabel="time [s]", ylabel="angle and its target [°]")
    for panel in (upper, lower):
        panel.legend()
        panel.grid(alpha=0.3)
    if save:
        figure.savefig(save, dpi=150)
    else:
        plt.show()


if __name__ == "__main__":
    main()
