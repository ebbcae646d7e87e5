"""The interface of the FMUs, written by hand from the design: names, types, units, start values.

Deliberately no part of it is generated: the FMUs' own declarations are tested against it. More variables may exist.
Units are compared by their base units, so "N.m2" and "Nm2" are the same; `None` leaves the unit open.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

CONTROLLERS = ("NabfcController", "PdsController", "PdController")
# NabfcController with the paper's law, which is not its default.
PAPER: dict[str, float | str] = {"law": "paper"}
PLANT = "DualArmPlant"
INSTRUMENTS = "GraspInstruments"
ACTUATORS = "GraspActuators"
FMUS = (PLANT, *CONTROLLERS, INSTRUMENTS, ACTUATORS)


@dataclass(frozen=True)
class Variable:
    """One row of the contract."""

    name: str
    causality: str
    unit: str | None = None
    start: float | None = None
    type: str = "Real"
    items: tuple[str, ...] = ()

    @property
    def is_angle(self) -> bool:
        """Angles are in rad and shown in degrees."""
        return self.unit == "rad"


def _rows(causality: str, unit: str | None, names: str, start: float | None = None) -> list[Variable]:
    return [Variable(name, causality, unit, start) for name in names.split()]


# The plant measures these, and every controller gets them.
MEASURED = {
    "theta1": "rad",
    "theta2": "rad",
    "theta1_dot": "rad/s",
    "theta2_dot": "rad/s",
    "y_object": "m",
    "y_object_dot": "m/s",
    "root_moment1": "N.m",
    "root_moment2": "N.m",
    "tip_shear1": "N",
    "tip_shear2": "N",
    "tip_shear1_dot": "N/s",
    "tip_shear2_dot": "N/s",
}

# What the plant outputs too and NABFC's root-strain law measures, after the references.
MOMENT_RATES = {"root_moment1_dot": "N.m/s", "root_moment2_dot": "N.m/s"}

# What GraspInstruments shows a controller.
SHOWN = {**MEASURED, **MOMENT_RATES}

# A controller commands these, and the plant takes them.
COMMANDS = {"tau1_cmd": "N.m", "tau2_cmd": "N.m", "u_cmd": "N"}

_PLANT = [
    *(Variable(name, "input", unit) for name, unit in COMMANDS.items()),
    *_rows("input", "N.m", "delta_f1 delta_f2"),
    *_rows("input", "N", "delta_F"),
    *(Variable(name, "output", unit) for name, unit in (MEASURED | MOMENT_RATES).items()),
    *_rows("output", "N", "lambda1 lambda2 contact_force1 contact_force2 u"),
    *_rows("output", "N.m", "tau1 tau2"),
    *_rows("output", "m", "tip_deflection1 tip_deflection2 constraint1 constraint2"),
    *_rows("output", "J", "energy supplied_energy"),
    Variable("in_contact", "output", type="Boolean"),
    *(Variable(f"deflection{arm}[{point}]", "output", "m") for arm in (1, 2) for point in range(1, 12)),
    *_rows("parameter", "N.m2", "EI1 EI2", 0.115),
    *_rows("parameter", "kg/m", "rho1 rho2", 0.054),
    *_rows("parameter", "m", "l", 0.2),
    *_rows("parameter", "m", "L", 0.1),
    *_rows("parameter", "kg", "m1 m2", 0.1),
    *_rows("parameter", "kg", "M", 0.3),
    *_rows("parameter", "kg.m2", "J1 J2", 0.0073),
    *_rows("parameter", "s", "root_uncertainty", 0.1),
    *_rows("parameter", "s", "tip_uncertainty", 0.05),
    *_rows("parameter", "s", "kelvin_voigt", 0.0),
    *_rows("parameter", "N.m", "k_M1", 2.1),
    *_rows("parameter", "N.m", "k_m1", -2.1),
    *_rows("parameter", "N.m", "m_r1", 0.1),
    *_rows("parameter", "N.m", "m_l1", -0.1),
    *_rows("parameter", "N", "k_M2", 0.31),
    *_rows("parameter", "N", "k_m2", -0.31),
    *_rows("parameter", "N", "m_r2", 0.01),
    *_rows("parameter", "N", "m_l2", -0.01),
    *_rows("parameter", "", "k_r1 k_l1 k_r2 k_l2", 1.0),
    Variable("actuator_model", "parameter", type="Enumeration", items=("ideal", "compensated", "raw")),
    Variable("order", "parameter", start=8, type="Integer"),
    *_rows("parameter", "rad", "theta1_0 theta2_0", 0.0),
    *_rows("parameter", "rad/s", "theta1_dot_0 theta2_dot_0", 0.0),
    *_rows("parameter", "m", "y_object_0", 0.05),
    *_rows("parameter", "m/s", "y_object_dot_0", 0.0),
]

_CONTROLLER = [
    *(Variable(name, "input", unit) for name, unit in MEASURED.items()),
    *_rows("input", "N", "lambda1_ref", -0.5),
    *_rows("input", "rad", "theta1_ref", math.radians(3)),
    *(Variable(name, "input", unit) for name, unit in MOMENT_RATES.items()),
    *(Variable(name, "output", unit) for name, unit in COMMANDS.items()),
    *_rows("output", "rad", "theta1_d theta2_d e1 e2"),
    *_rows("output", "m", "y_object_d p"),
    *_rows("output", "N", "lambda2_d"),
    *_rows("parameter", "N.m2", "EI1 EI2", 0.115),
    *_rows("parameter", "m", "l", 0.2),
    *_rows("parameter", "m", "L", 0.1),
]


def _gains(kp: float, kv: float, kp_hub: float, kv_hub: float) -> list[Variable]:
    return [
        *_rows("parameter", "N/m", "kp", kp),
        *_rows("parameter", "N.s/m", "kv", kv),
        *_rows("parameter", "N.m/rad", "kp1 kp2", kp_hub),
        *_rows("parameter", "N.m.s/rad", "kv1 kv2", kv_hub),
    ]


_ACTUATION = [
    *_rows("parameter", "N.m", "tau_limit", 2.0),
    *_rows("parameter", "N", "u_limit", 0.3),
    *_rows("parameter", "kg.m2", "observer_inertia1 observer_inertia2", 0.0073),
    *_rows("parameter", "kg", "observer_mass", 0.5),
    *_rows("parameter", "rad/s", "observer_bandwidth", 300.0),
    Variable("rate_source", "parameter", type="Enumeration", items=("measured", "estimated")),
]

_INTEGRALS = [*_rows("parameter", "N/(m.s)", "ki", 0.0), *_rows("parameter", "N.m/(rad.s)", "ki1 ki2", 0.0)]

_PER_ARM = ("xi", "k", "mu", "c3", "epsilon2", "a3", "a4", "zeta1", "zeta2", "g1", "g2")

_NABFC = [
    *_rows("output", "m/s", "s"),
    *_rows("output", "rad/s", "s1 s2"),
    *_rows("output", "kg", "m_hat"),
    *_rows("output", "kg.m2", "J1_hat J2_hat"),
    *_rows("output", "N", "epsilon_hat"),
    *_rows("output", "N.m", "pi1_hat pi2_hat"),
    *_rows("output", None, "W_norm U1_norm U2_norm"),
    *_rows("parameter", None, "eta k mu_bar c1 epsilon1 a1 a2 gamma1 gamma2 b1 b2"),
    *(Variable(f"{name}{arm}", "parameter") for name in _PER_ARM for arm in (1, 2)),
    *_rows("parameter", "kg", "m_hat_0"),
    *_rows("parameter", "kg.m2", "J1_hat_0 J2_hat_0"),
    *_rows("parameter", None, "sat_limit"),
    *_rows("parameter", "rad/s", "shear_rate_bandwidth"),
    *_rows("parameter", "N", "W_max", 0.0),
    *_rows("parameter", "N.m", "U1_max U2_max", 0.0),
    Variable("law", "parameter", type="Enumeration", items=("paper", "root_strain")),
    *_rows("parameter", None, "r_slope r_reach r_strain r_slope1 r_reach1 r_strain1 r_slope2 r_reach2 r_strain2"),
    Variable("r_learner", "parameter", type="Enumeration", items=("observer", "networks")),
    *_rows("parameter", "kg", "r_mass_0 r_mass_min r_mass_max"),
    *_rows("parameter", None, "r_inertia_min r_inertia_max r_strain_rate_bandwidth"),
    *_rows("parameter", "rad/s", "r_strain_bandwidth"),
    *_ACTUATION,
]

# A signal's own unit is None here.
_SENSOR = {"noise": None, "bias": None, "lsb": None, "bandwidth": "rad/s", "delay": "s", "sample_time": "s"}

_INSTRUMENTS = [
    *(Variable(name, "input", unit, 0.0) for name, unit in SHOWN.items()),
    *(Variable(f"{name}_measured", "output", unit) for name, unit in SHOWN.items()),
    Variable("measures_rates", "output", type="Boolean"),
    Variable(
        "sensor_profile", "parameter", type="Enumeration", items=("parameters", "off", "noise", "encoders")
    ),
    *_rows("parameter", "s", "sample_time", 0.0),
    *_rows("parameter", "", "noise_scale", 1.0),
    Variable("seed", "parameter", start=1, type="Integer"),
    Variable("no_rates", "parameter", type="Boolean"),
    *(
        Variable(f"{name}_{what}", "parameter", unit or own, 0.0)
        for what, unit in _SENSOR.items()
        for name, own in SHOWN.items()
    ),
]

_ACTUATORS = [
    *(Variable(name, "input", unit, 0.0) for name, unit in COMMANDS.items()),
    *(Variable(f"{name}_sent", "output", unit) for name, unit in COMMANDS.items()),
    Variable("actuator_profile", "parameter", type="Enumeration", items=("parameters", "off", "delay")),
    *_rows("parameter", "s", "sample_time", 0.0),
    *(
        row
        for name, unit in COMMANDS.items()
        for row in (
            Variable(f"{name}_delay", "parameter", "s", 0.0),
            Variable(f"{name}_rate_limit", "parameter", f"{unit}/s", 0.0),
            Variable(f"{name}_bandwidth", "parameter", "rad/s", 0.0),
        )
    ),
    Variable("dead_zone_inverse", "parameter", type="Boolean"),
    *_rows("parameter", "N.m", "m_r1", 0.1),
    *_rows("parameter", "N.m", "m_l1", -0.1),
    *_rows("parameter", "N", "m_r2", 0.01),
    *_rows("parameter", "N", "m_l2", -0.01),
    *_rows("parameter", "", "k_r1 k_l1 k_r2 k_l2", 1.0),
]

CONTRACT: dict[str, list[Variable]] = {
    "DualArmPlant": _PLANT,
    "NabfcController": [*_CONTROLLER, *_NABFC],
    "PdsController": [
        *(*_CONTROLLER, *_gains(40, 35, 35, 15), *_INTEGRALS, *_ACTUATION),
        *_rows("parameter", "", "ks1 ks2", 10),
    ],
    "PdController": [*_CONTROLLER, *_gains(10, 9, 60, 55), *_INTEGRALS, *_ACTUATION],

    "PdsController": [*_CONTROLLER, *_gains(40, 35, 35, 15), *_rows("parameter", "", "ks1 ks2", 10)],
    "PdController": [*_CONTROLLER, *_gains(10, 9, 60, 55)],
    INSTRUMENTS: _INSTRUMENTS,
    ACTUATORS: _ACTUATORS,
}

# Outputs that follow inputs at once; the design: what depends directly on inputs does, the rest waits for fmi2DoStep.
DIRECT: dict[str, dict[str, set[str]]] = {
    "DualArmPlant": {
        "tau1": {"tau1_cmd"},
        "tau2": {"tau2_cmd"},
        "u": {"u_cmd"},
        **{name: {"u_cmd", "delta_F"} for name in ("lambda1", "lambda2", "contact_force1", "contact_force2")},
        "in_contact": {"u_cmd", "delta_F"},
    },
    **{
        name: {
            "theta1_d": {"theta1_ref"},
            "theta2_d": {"theta1_ref", "lambda1_ref"},
            "y_object_d": {"theta1_ref", "lambda1_ref"},
            "lambda2_d": {"lambda1_ref"},
            "e1": {"theta1", "theta1_ref"},
            "e2": {"theta2", "theta1_ref", "lambda1_ref"},
            "p": {"y_object", "theta1_ref", "lambda1_ref"},
        }
        for name in CONTROLLERS
    },
    INSTRUMENTS: {f"{name}_measured": {name} for name in SHOWN},
    ACTUATORS: {f"{name}_sent": {name} for name in COMMANDS},
}

# All of the common and the co-simulation functions of FMI 2.0.
EXPORTS = {
    *(f"fmi2{verb}{kind}" for verb in ("Get", "Set") for kind in ("Real", "Integer", "Boolean", "String", "FMUstate")),
    *(f"fmi2Get{kind}Status" for kind in ("", "Real", "Integer", "Boolean", "String")),
    *("fmi2GetTypesPlatform", "fmi2GetVersion", "fmi2SetDebugLogging", "fmi2Instantiate", "fmi2FreeInstance"),
    *("fmi2SetupExperiment", "fmi2EnterInitializationMode", "fmi2ExitInitializationMode", "fmi2Terminate", "fmi2Reset"),
    *("fmi2FreeFMUstate", "fmi2SerializedFMUstateSize", "fmi2SerializeFMUstate", "fmi2DeSerializeFMUstate"),
    *("fmi2GetDirectionalDerivative", "fmi2SetRealInputDerivatives", "fmi2GetRealOutputDerivatives"),
    *("fmi2DoStep", "fmi2CancelStep"),
    *("fmi2EnterEventMode", "fmi2NewDiscreteStates", "fmi2EnterContinuousTimeMode", "fmi2CompletedIntegratorStep"),
    *("fmi2SetTime", "fmi2SetContinuousStates", "fmi2GetContinuousStates", "fmi2GetDerivatives", "fmi2GetEventIndicators"),
    "fmi2GetNominalsOfContinuousStates",
}
