//! Values in a scenario file: constants, signals and their points, in every way they may be written.

use std::fmt;

use serde::Deserialize;
use serde::de::{Deserializer, Error as _, MapAccess, Visitor};

use crate::signal::{Level, Shape, Signal};
use fmi2_import::Value;

/// A number, a truth value or a text.
pub(super) struct Constant(pub Value);

/// The value at which an input is held, or its signal over time.
pub(super) enum Input {
    Constant(Value),
    Varying(Signal),
}

/// A number, a truth value as 1 or 0, or a name.
struct Point(Level);

/// The probable intention behind a nested table under a name.
const DOTTED: &str = "a value (write \"Component.name\" with its quotation marks)";

impl<'de> Deserialize<'de> for Constant {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Any;
        impl Visitor<'_> for Any {
            type Value = Constant;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(DOTTED)
            }
            fn visit_bool<E>(self, value: bool) -> Result<Constant, E> {
                Ok(Constant(value.into()))
            }
            fn visit_i64<E>(self, value: i64) -> Result<Constant, E> {
                Ok(Constant(integer(value)))
            }
            fn visit_f64<E>(self, value: f64) -> Result<Constant, E> {
                Ok(Constant(value.into()))
            }
            fn visit_str<E>(self, value: &str) -> Result<Constant, E> {
                Ok(Constant(value.into()))
            }
        }
        deserializer.deserialize_any(Any)
    }
}

/// A whole number; one that no FMI integer can be may still be a real.
#[allow(clippy::cast_precision_loss)] // as a real has it
fn integer(value: i64) -> Value {
    i32::try_from(value).map_or(Value::Real(value as f64), Value::Integer)
}

impl<'de> Deserialize<'de> for Point {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Any;
        impl Visitor<'_> for Any {
            type Value = Point;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number, true or false, or the name of an enumeration's item")
            }
            fn visit_bool<E>(self, value: bool) -> Result<Point, E> {
                Ok(Point(Level::Number(f64::from(u8::from(value)))))
            }
            #[allow(clippy::cast_precision_loss)] // times and values of this size are exact
            fn visit_i64<E>(self, value: i64) -> Result<Point, E> {
                Ok(Point(Level::Number(value as f64)))
            }
            fn visit_f64<E>(self, value: f64) -> Result<Point, E> {
                Ok(Point(Level::Number(value)))
            }
            fn visit_str<E>(self, value: &str) -> Result<Point, E> {
                Ok(Point(Level::Name(value.to_owned())))
            }
        }
        deserializer.deserialize_any(Any)
    }
}

impl<'de> Deserialize<'de> for Input {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Any;
        impl<'de> Visitor<'de> for Any {
            type Value = Input;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a value, or steps or linear with a list of [time, value]")
            }
            fn visit_bool<E>(self, value: bool) -> Result<Input, E> {
                Ok(Input::Constant(value.into()))
            }
            fn visit_i64<E>(self, value: i64) -> Result<Input, E> {
                Ok(Input::Constant(integer(value)))
            }
            fn visit_f64<E>(self, value: f64) -> Result<Input, E> {
                Ok(Input::Constant(value.into()))
            }
            fn visit_str<E>(self, value: &str) -> Result<Input, E> {
                Ok(Input::Constant(value.into()))
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Input, A::Error> {
                const SHAPES: &[&str] = &["steps", "linear"];
                let Some(key) = map.next_key::<String>()? else {
                    return Err(A::Error::custom("steps or linear is missing"));
                };
                let shape = match key.as_str() {
                    "steps" => Shape::Steps,
                    "linear" => Shape::Linear,
                    other => {
                        return Err(A::Error::custom(format!(
                            "unknown shape `{other}`, expected `{}`; a component's input is written \"Component.name\" with its \
                             quotation marks",
                            SHAPES.join("` or `")
                        )));
                    }
                };
                let points: Vec<Vec<Point>> = map.next_value()?;
                if map.next_key::<String>()?.is_some() {
                    return Err(A::Error::custom("an input has steps or linear, not both"));
                }
                let point = |point: Vec<Point>| match <[Point; 2]>::try_from(point) {
                    Ok([Point(Level::Number(time)), Point(value)]) => Ok((time, value)),
                    Ok(_) => Err(A::Error::custom("expected a number for the time of a point")),
                    Err(point) => {
                        Err(A::Error::custom(format!("a point is [time, value], not {} numbers", point.len())))
                    }
                };
                let points = points.into_iter().map(point).collect::<Result<_, _>>()?;
                Signal::with_names(shape, points).map(Input::Varying).map_err(A::Error::custom)
            }
        }
        deserializer.deserialize_any(Any)
    }
}
