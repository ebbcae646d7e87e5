//! The parameters by name, with unit and range. The same tables declare and check them.

use super::{Arm, Channel, Face, ORDER_RANGE, Parameters, Start};
use parameter_table::{Admissible, InvalidParameter, Parameter, Range, check, check_family, parameter};

/// The largest magnitude of any parameter, in its SI unit: far beyond anything physical.
const LARGEST: f64 = 1e9;
const POSITIVE: Range = Range::new(1e-9, LARGEST);
const NOT_NEGATIVE: Range = Range::new(0.0, LARGEST);
const NOT_POSITIVE: Range = Range::new(-LARGEST, 0.0);
const ANY: Range = Range::new(-LARGEST, LARGEST);

impl Arm {
    /// The parameters of each arm.
    pub const PARAMETERS: [Parameter<Self>; 4] = [
        parameter!("EI{}", "N.m2", POSITIVE, "Flexural rigidity of arm {}", ei),
        parameter!("rho{}", "kg/m", POSITIVE, "Mass per length of arm {}", rho),
        parameter!("m{}", "kg", POSITIVE, "Point mass at the tip of arm {}", tip_mass),
        parameter!("J{}", "kg.m2", POSITIVE, "Moment of inertia of hub {}", hub_inertia),
    ];
}

impl Face {
    /// The parameters of each face of a compliant object.
    pub const PARAMETERS: [Parameter<Self>; 2] = [
        parameter!(
            "contact_stiffness{}",
            "N/m",
            POSITIVE,
            "Stiffness of the object's face at tip {}, with contact_model = compliant",
            stiffness
        ),
        parameter!(
            "contact_damping{}",
            "N.s/m",
            NOT_NEGATIVE,
            "Damping of the object's face at tip {}, with contact_model = compliant",
            damping
        ),
    ];
}

/// A channel's parameters from its number, unit and name.
macro_rules! channel {
    ($number:literal, $unit:literal, $name:literal) => {{
        macro_rules! row {
            ($symbol:literal, $row_unit:literal, $range:ident, $text:literal, $field:ident) => {
                parameter!(
                    concat!($symbol, $number),
                    $row_unit,
                    $range,
                    concat!($text, ", ", $name, " channel, eq. (18)"),
                    $field
                )
            };
        }
        [
            row!("k_M", $unit, NOT_NEGATIVE, "Upper saturation level", k_max),
            row!("k_m", $unit, NOT_POSITIVE, "Lower saturation level", k_min),
            row!("m_r", $unit, NOT_NEGATIVE, "Upper end of the dead zone", m_r),
            row!("m_l", $unit, NOT_POSITIVE, "Lower end of the dead zone", m_l),
            row!("k_r", "1", POSITIVE, "Slope above the dead zone", k_r),
            row!("k_l", "1", POSITIVE, "Slope below the dead zone", k_l),
        ]
    }};
}

impl Channel {
    /// The parameters of the hub motors. Besides its range, each saturation level lies beyond its end of the dead zone.
    pub const TORQUE_PARAMETERS: [Parameter<Self>; 6] = channel!("1", "N.m", "hub torque");
    /// The parameters of the object's actuator, as those of the hub motors.
    pub const FORCE_PARAMETERS: [Parameter<Self>; 6] = channel!("2", "N", "object force");

    fn check(&self, table: &[Parameter<Self>; 6]) -> Result<(), InvalidParameter> {
        check(table, self)?;
        let [k_max, k_min, m_r, m_l, ..] = table.map(|row| row.name);
        Admissible::Above(m_r, self.m_r, LARGEST).check(k_max, self.k_max)?;
        Admissible::Below(m_l, self.m_l, -LARGEST).check(k_min, self.k_min)
    }
}

impl Start {
    /// Start values of the hubs.
    pub const ANGLES: [Parameter<Self>; 4] = [
        parameter!("theta1_0", "rad", ANY, "Angle of hub 1 at the start", theta[0]),
        parameter!("theta1_dot_0", "rad/s", ANY, "Angular velocity of hub 1 at the start", theta_dot[0]),
        parameter!("theta2_0", "rad", ANY, "Angle of hub 2 at the start", theta[1]),
        parameter!("theta2_dot_0", "rad/s", ANY, "Angular velocity of hub 2 at the start", theta_dot[1]),
    ];
    /// Start values of the object.
    pub const OBJECT: [Parameter<Self>; 2] = [
        parameter!(
            "y_object_0",
            "m",
            ANY,
            "Position of the object at the start; the arms' shapes follow from it and the hub angles",
            y_object
        ),
        parameter!("y_object_dot_0", "m/s", ANY, "Velocity of the object at the start", y_object_dot),
    ];
}

impl Parameters {
    /// The parameters of the plant as a whole. The rest: [`order`](Self::order) in [`ORDER_RANGE`], and the tables of
    /// [`Arm`], [`Face`], [`Channel`] and [`Start`].
    pub const COMMON: [Parameter<Self>; 6] = [
        parameter!("l", "m", POSITIVE, "Length of each arm", length),
        parameter!(
            "L",
            "m",
            POSITIVE,
            "Width of the object and distance of the hubs: straight arms just touch it",
            object_width
        ),
        parameter!("M", "kg", POSITIVE, "Mass of the object", object_mass),
        parameter!(
            "root_uncertainty",
            "s",
            NOT_NEGATIVE,
            "c_f of the built-in disturbance -c_f d/dt EI w''(0) on each hub; 0 = none",
            root_uncertainty
        ),
        parameter!(
            "tip_uncertainty",
            "s",
            NOT_NEGATIVE,
            "c_F of the built-in disturbance -c_F (EI1+EI2) d/dt(w1'''(l)+w2'''(l)) on the object; 0 = none",
            tip_uncertainty
        ),
        parameter!(
            "kelvin_voigt",
            "s",
            NOT_NEGATIVE,
            "Kelvin-Voigt coefficient: the arms transmit the moment EI (w'' + kelvin_voigt d/dt w''); 0 = none",
            kelvin_voigt
        ),
    ];

    /// The parameters of impacts on rigid faces that can open.
    pub const IMPACT: [Parameter<Self>; 2] = [
        parameter!(
            "restitution",
            "1",
            Range::new(0.0, 1.0),
            "Coefficient of restitution of impacts, with contact_model = unilateral; 0 = plastic, 1 = elastic",
            restitution
        ),
        parameter!(
            "plastic_speed",
            "m/s",
            POSITIVE,
            "Impacts slower than this are plastic whatever the restitution, so that bounces end in contact",
            plastic_speed
        ),
    ];

    /// Checks every parameter against its range.
    ///
    /// # Errors
    /// The first parameter found outside its range, by its name in the tables.
    pub fn validate(&self) -> Result<(), InvalidParameter> {
        check_family(&Arm::PARAMETERS, &self.arms)?;
        check(&Self::COMMON, self)?;
        check_family(&Face::PARAMETERS, &self.faces)?;
        check(&Self::IMPACT, self)?;
        let (least, greatest) = (*ORDER_RANGE.start() as f64, *ORDER_RANGE.end() as f64);
        Admissible::Within(Range::new(least, greatest)).check("order", self.order as f64)?;
        self.torque_channel.check(&Channel::TORQUE_PARAMETERS)?;
        self.force_channel.check(&Channel::FORCE_PARAMETERS)?;
        check(&Start::ANGLES, &self.start)?;
        check(&Start::OBJECT, &self.start)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each assignment of an inadmissible value, with the name the error must carry.
    #[test]
    fn every_parameter_is_checked_by_name() {
        type Spoil = fn(&mut Parameters, f64);
        let spoilers: [(&str, Spoil, &[f64]); 38] = [
            ("EI1", |p, v| p.arms[0].ei = v, &[0.0, -1.0]),
            ("EI2", |p, v| p.arms[1].ei = v, &[0.0, -1.0]),
            ("rho1", |p, v| p.arms[0].rho = v, &[0.0, -1.0]),
            ("rho2", |p, v| p.arms[1].rho = v, &[0.0, -1.0]),
            ("J1", |p, v| p.arms[0].hub_inertia = v, &[0.0, -1.0]),
            ("J2", |p, v| p.arms[1].hub_inertia = v, &[0.0, -1.0]),
            ("m1", |p, v| p.arms[0].tip_mass = v, &[0.0, -1.0]),
            ("m2", |p, v| p.arms[1].tip_mass = v, &[0.0, -1.0]),
            ("l", |p, v| p.length = v, &[0.0, -1.0]),
            ("L", |p, v| p.object_width = v, &[0.0, -1.0]),
            ("M", |p, v| p.object_mass = v, &[0.0, -1.0]),
            ("root_uncertainty", |p, v| p.root_uncertainty = v, &[-1e-3]),
            ("tip_uncertainty", |p, v| p.tip_uncertainty = v, &[-1e-3]),
            ("kelvin_voigt", |p, v| p.kelvin_voigt = v, &[-1e-3]),
            ("contact_stiffness1", |p, v| p.faces[0].stiffness = v, &[0.0, -1.0]),
            ("contact_stiffness2", |p, v| p.faces[1].stiffness = v, &[0.0, -1.0]),
            ("contact_damping1", |p, v| p.faces[0].damping = v, &[-1e-3]),
            ("contact_damping2", |p, v| p.faces[1].damping = v, &[-1e-3]),
            ("restitution", |p, v| p.restitution = v, &[-0.1, 1.1]),
            ("plastic_speed", |p, v| p.plastic_speed = v, &[0.0, -1.0]),
            ("k_M1", |p, v| p.torque_channel.k_max = v, &[0.1, -1.0]),
            ("k_m1", |p, v| p.torque_channel.k_min = v, &[-0.1, 1.0]),
            ("m_r1", |p, v| p.torque_channel.m_r = v, &[-0.1]),
            ("m_l1", |p, v| p.torque_channel.m_l = v, &[0.1]),
            ("k_r1", |p, v| p.torque_channel.k_r = v, &[0.0, -1.0]),
            ("k_l1", |p, v| p.torque_channel.k_l = v, &[0.0, -1.0]),
            ("k_M2", |p, v| p.force_channel.k_max = v, &[0.01, -1.0]),
            ("k_m2", |p, v| p.force_channel.k_min = v, &[-0.01, 1.0]),
            ("m_r2", |p, v| p.force_channel.m_r = v, &[-0.1]),
            ("m_l2", |p, v| p.force_channel.m_l = v, &[0.1]),
            ("k_r2", |p, v| p.force_channel.k_r = v, &[0.0, -1.0]),
            ("k_l2", |p, v| p.force_channel.k_l = v, &[0.0, -1.0]),
            ("theta1_0", |p, v| p.start.theta[0] = v, &[]),
            ("theta2_0", |p, v| p.start.theta[1] = v, &[]),
            ("theta1_dot_0", |p, v| p.start.theta_dot[0] = v, &[]),
            ("theta2_dot_0", |p, v| p.start.theta_dot[1] = v, &[]),
            ("y_object_0", |p, v| p.start.y_object = v, &[]),
            ("y_object_dot_0", |p, v| p.start.y_object_dot = v, &[]),
        ];
        for (name, spoil, values) in spoilers {
            let never = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 2.0 * LARGEST];
            for value in values.iter().chain(&never) {
                let mut parameters = Parameters::default();
                spoil(&mut parameters, *value);
                let error = parameters.validate().expect_err(name);
                assert_eq!(error.name, name);
                assert_eq!(error.value.to_bits(), value.to_bits());
            }
        }
        for order in [0, 3, 25, usize::MAX] {
            let error = Parameters { order, ..Parameters::default() }.validate().unwrap_err();
            assert_eq!(error.name, "order");
        }
    }

    #[test]
    fn the_message_says_what_is_wrong_and_what_would_be_right() {
        let mut parameters = Parameters::default();
        parameters.torque_channel.k_max = 0.05;
        assert_eq!(
            parameters.validate().unwrap_err().to_string(),
            "parameter k_M1 = 0.05 is not admissible: it must be greater than m_r1 = 0.1 and at most 1000000000"
        );
    }
}
