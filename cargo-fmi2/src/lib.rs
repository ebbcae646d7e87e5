#![doc = include_str!("../README.md")]

mod names;
pub mod new;
pub mod package;
