//! Numbers on the command line, and messages for other texts.

use std::str::FromStr;

/// A time or a length of time in s; which ones make sense is the option's matter.
pub fn seconds(text: &str) -> Result<f64, String> {
    read(text, "write a number of seconds, such as 0.5 or 1e-4")
}

/// A number.
pub fn number(text: &str) -> Result<f64, String> {
    read(text, "write a number, such as 0.5 or 1e-4")
}

/// How many.
pub fn count(text: &str) -> Result<usize, String> {
    read(text, "write a whole number, such as 8")
}

/// A number that names one of many.
pub fn index(text: &str) -> Result<u64, String> {
    read(text, "write a whole number, such as 42")
}

/// The order of a plant's modal model.
pub fn order(text: &str) -> Result<u8, String> {
    const WANTED: &str = "write a whole number from 4 to 24";
    read(text, WANTED).and_then(|order| if (4..=24).contains(&order) { Ok(order) } else { Err(WANTED.to_owned()) })
}

fn read<T: FromStr>(text: &str, wanted: &str) -> Result<T, String> {
    text.trim().parse().map_err(|_| wanted.to_owned())
}
