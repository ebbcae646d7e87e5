"""Plant and controller wired by hand with FMPy: the grasp force comes to 0.5 N.

    python examples/grasp.py
    python examples/grasp.py --controller PdsController --stop 2 --set M=1.0
    python grasp.py --dist ~/Downloads/fmus          # a copy of this file, anywhere

The other examples import `Grasp` from here; a copy of this file is all that is needed to use it elsewhere.
"""

from __future__ import annotations

import argparse
import shutil
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

PLANT = "DualArmPlant.fmu"
CONTROLLERS = ("NabfcController", "PdsController", "PdController")
SET = "a parameter or an input; an item of an enumeration by its number, from 1; repeatable"


def find_dist(wanted: str | None = None) -> Path:
    """The folder of the FMUs: the one that is named, or `dist` here, or `dist` beside or above this file."""
    if wanted is not None:
        folders = [Path(wanted).expanduser()]
    else:
        folders = [Path("dist"), *(folder / "dist" for folder in Path(__file__).resolve().parents)]
    for folder in folders:
        if (folder / PLANT).is_file():
            return folder
    searched = folders[0] if wanted is not None else "./dist and the folders above this file"
    raise SystemExit(f"{PLANT} is not in {searched}: name the folder of the FMUs with --dist")


class Component:
    """One instance of an FMU, its variables addressed by name."""

    def __init__(self, path: Path) -> None:
        description = read_model_description(str(path))
        self.variables = {v.name: v for v in description.modelVariables}
        self.folder = extract(str(path))
        self.fmu = FMU2Slave(
            guid=description.guid,
            unzipDirectory=self.folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=path.stem,
        )
        self.fmu.instantiate()

    def reals(self, causality: str) -> dict[str, int]:
        """Value references of the real inputs, outputs or parameters, by name."""
        return {
            name: v.valueReference for name, v in self.variables.items() if (v.causality, v.type) == (causality, "Real")
        }

    def get(self, *names: str) -> list[float]:
        """Values of real variables."""
        return self.fmu.getReal([self.variables[name].valueReference for name in names])

    def set(self, name: str, value: float) -> None:
        """Sets a variable: an enumeration by the number of its item, counted from 1."""
        variable = self.variables[name]
        if variable.type == "Real":
            self.fmu.setReal([variable.valueReference], [value])
        else:
            self.fmu.setInteger([variable.valueReference], [int(value)])

    def close(self) -> None:
        """Frees the instance and deletes the unpacked FMU."""
        self.fmu.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)


class Grasp:
    """The plant with one of the three controllers; ready to step."""

    def __init__(self, controller: str = "NabfcController", dist: Path | None = None, **settings: float) -> None:
        dist = dist or find_dist()
        self.time = 0.0
        self.plant = Component(dist / PLANT)
        self.controller = Component(dist / f"{controller}.fmu")
        components = (self.plant, self.controller)
        # Parameters and references must be set before initialisation. Both sides have EI1, EI2, l and L; the controller
        # could be told something else than the plant, but here both get the value.
        for name, value in settings.items():
            owners = [c for c in components if name in c.variables]
            if not owners:
                raise SystemExit(f"neither DualArmPlant nor {controller} has a variable {name}")
            for component in owners:
                component.set(name, value)
        for component in components:
            component.fmu.setupExperiment(startTime=0.0)
            component.fmu.enterInitializationMode()
        # The wires: equal names. Fourteen measured signals go one way, three commands come back.
        self.measured = self.wire(self.plant, self.controller)
        self.commands = self.wire(self.controller, self.plant)
        self.exchange()
        for component in components:
            component.fmu.exitInitializationMode()

    @staticmethod
    def wire(source: Component, target: Component) -> tuple[list[int], list[int]]:
        """Value references of the outputs of `source` and of the inputs of `target` with the same names."""
        outputs, inputs = source.reals("output"), target.reals("input")
        names = [name for name in outputs if name in inputs]
        return [outputs[name] for name in names], [inputs[name] for name in names]

    def exchange(self) -> None:
        """Plant to controller, then controller to plant: commands follow measurements without delay."""
        plant, controller = self.plant.fmu, self.controller.fmu
        controller.setReal(self.measured[1], plant.getReal(self.measured[0]))
        plant.setReal(self.commands[1], controller.getReal(self.commands[0]))

    def step(self, size: float = 1e-4) -> None:
        """Both FMUs advance by `size` seconds with the signals exchanged before."""
        self.plant.fmu.doStep(self.time, size)
        self.controller.fmu.doStep(self.time, size)
        self.time += size
        self.exchange()

    def run(self, duration: float, *signals: str, step: float = 1e-4, every: int = 10) -> dict[str, np.ndarray]:
        """Advances by `duration`; returns "time" and these real outputs of either FMU, one row every `every` steps."""
        of_plant = [name for name in signals if name in self.plant.variables]
        of_controller = [name for name in signals if name not in of_plant]
        rows = []
        for i in range(round(duration / step) + 1):
            if i > 0:
                self.step(step)
            if i % every == 0:
                rows.append([self.time, *self.plant.get(*of_plant), *self.controller.get(*of_controller)])
        return dict(zip(("time", *of_plant, *of_controller), np.array(rows).T))

    def close(self) -> None:
        """Frees both instances."""
        self.plant.close()
        self.controller.close()


def settling_time(time: np.ndarray, signal: np.ndarray, goal: float, band: float = 0.02) -> float:
    """Time after which `signal` stays within `band` of its goal; infinite if it is outside at the end."""
    outside = np.flatnonzero(abs(signal - goal) > band * abs(goal))
    if outside.size == 0:
        return time[0]
    return time[outside[-1] + 1] if outside[-1] + 1 < len(time) else np.inf


def setting(text: str) -> tuple[str, float]:
    """Name and value of "NAME=NUMBER"; what is neither is an error of usage."""
    name, _, value = text.partition("=")
    try:
        return name, float(value)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not NAME=NUMBER, such as M=1.5") from None


def main() -> None:
    """Runs one grasp, prints when its forces have settled and plots it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--controller", choices=CONTROLLERS, default=CONTROLLERS[0])
    parser.add_argument("--stop", type=float, default=1.0, metavar="SECONDS")
    parser.add_argument("--set", type=setting, action="append", default=[], metavar="NAME=NUMBER", help=SET)
    parser.add_argument("--dist", metavar="FOLDER", help="where the FMUs are")
    parser.add_argument("--save", metavar="FILE", help="write the plot to FILE instead of opening a window")
    arguments = parser.parse_args()

    grasp = Grasp(arguments.controller, find_dist(arguments.dist), **dict(arguments.set))
    forces, torques = ("contact_force1", "contact_force2"), ("tau1", "tau2")
    result = grasp.run(arguments.stop, *forces, *torques, "u")
    goal = grasp.controller.get("lambda2_d")[0]
    grasp.close()

    for arm, name in enumerate(forces, 1):
        settled = settling_time(result["time"], result[name], goal)
        print(f"contact force {arm}: {result[name][-1]:.4f} N at the end, within 2 % from {settled:.3f} s on")

    figure, (upper, lower) = plt.subplots(2, sharex=True, figsize=(7, 6), layout="constrained")
    upper.axhspan(0.98 * goal, 1.02 * goal, color="gray", alpha=0.25, label="target ± 2 %")
    for arm, (name, style) in enumerate(zip(forces, ("-", "--")), 1):
        upper.plot(result["time"], result[name], style, label=f"arm {arm}")
    upper.set_ylabel("contact force [N]")
    for arm, (name, style) in enumerate(zip(torques, ("-", "--")), 1):
        lower.plot(result["time"], result[name], style, label=f"torque on hub {arm} [N·m]")
    lower.plot(result["time"], result["u"], ":", color="black", label="force on the object [N]")
    lower.set(xlabel="time [s]", ylabel="actuators")
    for panel in (upper, lower):
        panel.legend()
        panel.grid(alpha=0.3)
    figure.suptitle(arguments.controller)
    if arguments.save:
        figure.savefig(arguments.save, dpi=150)
    else:
        plt.show()


if __name__ == "__main__":
    main()
