//! All of these tests in one program: compiled apart, each of them would contain what it needs of the linear algebra again.

mod conservation;
mod contact;
mod contact_equations;
mod discrete;
mod equal_arms;
mod equations;
mod integrator;
mod properties;
mod response;
mod right_hand_side;
mod robustness;
mod spectrum;
