"""What `values.json` holds: the systems, inputs and times."""

from __future__ import annotations

from dataclasses import dataclass

from mpmath import mp, mpf

from .response import LoadsOf
from .system import PD, PDS, Feedback, Loads, Plant, System, target

PAPER = Plant()
UNEQUAL = Plant(EI=(0.115, 0.2), rho=(0.054, 0.08), J=(0.0073, 0.004), m_tip=(0.1, 0.05), M=0.5)

PLANTS: dict[str, Plant] = {
    "paper": PAPER,
    "unequal": UNEQUAL,
    "light_object": Plant(M=0.01, m_tip=(0.005, 0.005)),
    "heavy_object": Plant(M=5.0),
    "soft_arms": Plant(EI=(0.01, 0.01)),
    "stiff_arms": Plant(EI=(2.0, 2.0)),
    "kelvin_voigt": Plant(kelvin_voigt=1e-3),
    "unequal_kelvin_voigt": Plant(
        EI=UNEQUAL.EI, rho=UNEQUAL.rho, J=UNEQUAL.J, m_tip=UNEQUAL.m_tip, M=UNEQUAL.M, kelvin_voigt=1e-3
    ),
}

FEEDBACKS: dict[str, Feedback] = {"none": Feedback(), "pd": PD, "pds": PDS}


@dataclass(frozen=True)
class Loop:
    """A system whose eigenvalues are listed."""

    plant: str
    feedback: str
    uncertainties: bool = True

    def system(self) -> System:
        """The system itself."""
        plant = PLANTS[self.plant] if self.uncertainties else PLANTS[self.plant].without_uncertainties()
        return System(plant, FEEDBACKS[self.feedback])

    @property
    def zero_multiplicity(self) -> int:
        """Of the eigenvalue 0: the rigid motion of the free plant."""
        return 2 if self.feedback == "none" else 0


LOOPS: dict[str, Loop] = {
    **{f"{plant}_free": Loop(plant, "none", uncertainties=False) for plant in PLANTS},
    **{f"{plant}_no_control": Loop(plant, "none") for plant in PLANTS},
    "paper_pd": Loop("paper", "pd"),
    "paper_pds": Loop("paper", "pds"),
    "paper_pd_without_uncertainties": Loop("paper", "pd", uncertainties=False),
    "unequal_pds": Loop("unequal", "pds"),
}


@dataclass(frozen=True)
class Step:
    """A step of one command (tau1, tau2, u: amplitude in N.m or N) or of the target, from rest."""

    loop: str
    input: str
    amplitude: str
    times: tuple[str, ...] = ("0.01", "0.05", "0.2", "0.5", "1")

    def loads(self, system: System) -> LoadsOf:
        """Laplace transforms of what it applies."""
        if self.input == "target":
            goal = target(system.plant, self.amplitude, mp.radians(mpf(TARGET_THETA1_DEG)))
            return lambda s: system.reference_loads(s, goal)
        a = mpf(self.amplitude)
        torques = {"tau1": (a, 0), "tau2": (0, a), "u": (0, 0)}[self.input]
        force = a if self.input == "u" else 0
        return lambda s: Loads((torques[0] / s, torques[1] / s), force / s)


# A hundredth of the paper's target (lambda_1 = -0.5 N, theta_1 = 3 deg): no actuator saturates.
TARGET_THETA1_DEG = "0.03"
TARGET_LAMBDA1 = "-0.005"

STEPS: dict[str, Step] = {
    "paper_tau1": Step("paper_no_control", "tau1", "0.05"),
    "unequal_tau1": Step("unequal_no_control", "tau1", "0.05"),
    "unequal_tau2": Step("unequal_no_control", "tau2", "-0.08"),
    "unequal_u": Step("unequal_no_control", "u", "0.2"),
    "kelvin_voigt_tau1": Step("kelvin_voigt_no_control", "tau1", "0.05"),
    "unequal_kelvin_voigt_u": Step("unequal_kelvin_voigt_no_control", "u", "0.2"),
    "paper_pd_target": Step("paper_pd", "target", TARGET_LAMBDA1, ("0.1", "0.5", "1", "2")),
    "paper_pds_target": Step("paper_pds", "target", TARGET_LAMBDA1, ("0.1", "0.5", "1", "2")),
}
