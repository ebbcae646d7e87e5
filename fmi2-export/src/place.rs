//! The way from a model, whose type is forgotten, to a value in it.
//!
//! What is done with variables is compiled once for all models of a library, not once for each: it knows a model as a pointer, and
//! its variables as the places here. Only what a place was made from knows the model's type.

use std::marker::PhantomData;
use std::mem;
use std::ptr::{self, NonNull};
use std::sync::Arc;

/// A field of the model, which is always at the same distance from its beginning: reading and writing it costs no call.
///
/// Made by [`field!`](crate::field).
pub struct Field<M, T> {
    offset: usize,
    types: PhantomData<fn(&mut M) -> &mut T>,
}

impl<M, T> Field<M, T> {
    /// What [`field!`](crate::field) makes.
    ///
    /// # Safety
    /// The function must lead to what is `offset` bytes behind the beginning of the model, of every model.
    #[doc(hidden)]
    #[must_use]
    pub const unsafe fn new(offset: usize, _: fn(&mut M) -> &mut T) -> Self {
        Self { offset, types: PhantomData }
    }

    /// How many bytes behind the beginning of the model it is.
    pub(crate) fn offset(self) -> usize {
        self.offset
    }

    pub(crate) fn place(self) -> Place {
        Place { way: Way::Field(self.offset), base: 0, element: 0, then: None }
    }
}

impl<M, T, const N: usize> Field<M, [T; N]> {
    /// An element of the array, counted from 0.
    ///
    /// # Panics
    /// If there is none of this index.
    #[must_use]
    pub const fn element(self, index: usize) -> Field<M, T> {
        assert!(index < N, "the array has no such element");
        Field { offset: self.offset + index * size_of::<T>(), types: PhantomData }
    }
}

/// A [`Field`](struct@crate::Field) of a model: its type and the path to the field, as in `field!(Lag, settings.gain)`.
///
/// ```
/// # use fmi2_export::{Variables, field};
/// # #[derive(Default)] struct Pump { inputs: Inputs }
/// # #[derive(Default)] struct Inputs { speed: f64, valves: [f64; 3] }
/// # fn variables(variables: &mut Variables<Pump>) {
/// variables.input_field("speed", field!(Pump, inputs.speed)).description("Speed").unit("rad/s");
/// variables.input_field("valve{}", field!(Pump, inputs.valves)).description("Opening of valve {}");
/// variables.parameter_field("main", field!(Pump, inputs.valves).element(0)).description("Opening of the first again");
/// # }
/// ```
#[macro_export]
macro_rules! field {
    ($model:ty, $($path:tt).+) => {{
        let offset = ::core::mem::offset_of!($model, $($path).+);
        // SAFETY: `offset_of!` follows no references, so its path is that of the closure, in every model.
        #[allow(unsafe_code)]
        unsafe {
            $crate::Field::<$model, _>::new(offset, |model| &mut model.$($path).+)
        }
    }};
}

/// Where a value is in a model of the type that this was made for.
#[derive(Clone)]
pub(crate) struct Place {
    way: Way,
    /// How many bytes behind the model's beginning the way begins.
    base: usize,
    /// Which element of an array.
    element: usize,
    /// Where the value is in what the way leads to, if it is not that itself.
    then: Option<unsafe fn(*mut ()) -> *mut ()>,
}

#[derive(Clone)]
enum Way {
    /// So many bytes behind the model's beginning.
    Field(usize),
    Function(unsafe fn(*mut (), usize) -> *mut ()),
    /// A function that has captured something.
    Closure(Arc<Closure>),
}

type Closure = dyn Fn(*mut (), usize) -> *mut () + Send + Sync;

impl Place {
    /// Where a function leads.
    pub fn by<M: 'static, T: 'static>(field: impl Fn(&mut M) -> &mut T + Send + Sync + 'static) -> Self {
        Self::going(move |model: &mut M, _| ptr::from_mut(field(model)).cast())
    }

    /// Where the elements are of an array that a function leads to: see [`element`](Self::element).
    pub fn array<M: 'static, T: 'static>(field: impl Fn(&mut M) -> &mut [T] + Send + Sync + 'static) -> Self {
        Self::going(move |model: &mut M, element| ptr::from_mut(&mut field(model)[element]).cast())
    }

    fn going<M: 'static>(go: impl Fn(&mut M, usize) -> *mut () + Send + Sync + 'static) -> Self {
        Self { way: way(go), base: 0, element: 0, then: None }
    }

    /// The same of another element, `size` bytes long.
    pub fn element(&self, element: usize, size: usize) -> Self {
        let way = match self.way {
            Way::Field(offset) => Way::Field(offset + element * size),
            ref way => way.clone(),
        };
        Self { way, base: self.base, element, then: self.then }
    }

    /// The same in a part of the model, which is so many bytes behind the model's beginning.
    pub fn behind(self, base: usize) -> Self {
        match self.way {
            Way::Field(offset) => Self { way: Way::Field(base + offset), ..self },
            _ => Self { base, ..self },
        }
    }

    /// A value in what is at this place.
    pub fn then<P, T>(&self, field: fn(&mut P) -> &mut T) -> Self {
        // SAFETY: references and pointers to types with a size are passed alike. Whoever calls it promises that the pointer is such
        // a reference: see `of`.
        let then = unsafe { mem::transmute::<fn(&mut P) -> &mut T, unsafe fn(*mut ()) -> *mut ()>(field) };
        self.step(then)
    }

    #[inline(never)]
    fn step(&self, then: unsafe fn(*mut ()) -> *mut ()) -> Self {
        Self { then: Some(then), ..self.clone() }
    }

    /// How many bytes behind the model's beginning the value always is, if it is.
    pub fn offset(&self) -> Option<usize> {
        match (&self.way, self.then) {
            (Way::Field(offset), None) => Some(*offset),
            _ => None,
        }
    }

    /// Where the value is in this model: a pointer to be used as long as the model is not used otherwise.
    ///
    /// # Safety
    /// `model` must point to a model of the type that this place was made for, as a reference for writing does.
    pub unsafe fn of(&self, model: *mut ()) -> *mut () {
        // SAFETY: a part of the model is within it.
        let model = unsafe { model.byte_add(self.base) };
        let there = match &self.way {
            // SAFETY: a field of the model is within it.
            Way::Field(offset) => unsafe { model.byte_add(*offset) },
            // SAFETY: the caller's promise.
            Way::Function(function) => unsafe { function(model, self.element) },
            Way::Closure(closure) => closure(model, self.element),
        };
        match self.then {
            // SAFETY: it was made for what is there.
            Some(then) => unsafe { then(there) },
            None => there,
        }
    }
}

fn way<M: 'static, G: Fn(&mut M, usize) -> *mut () + Send + Sync + 'static>(go: G) -> Way {
    /// A function that has captured nothing needs no place in memory.
    unsafe fn call<M, G: Fn(&mut M, usize) -> *mut ()>(model: *mut (), element: usize) -> *mut () {
        // SAFETY: of no size; there was one, and it is never dropped.
        let go = unsafe { NonNull::<G>::dangling().as_ref() };
        // SAFETY: the caller's promise.
        go(unsafe { &mut *model.cast::<M>() }, element)
    }
    if size_of::<G>() == 0 {
        mem::forget(go);
        Way::Function(call::<M, G>)
    } else {
        // SAFETY: only `Place::of` calls it, whose caller promises that it is such a model.
        Way::Closure(Arc::new(move |model, element| go(unsafe { &mut *model.cast::<M>() }, element)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Default)]
    struct Model {
        first: u8,
        part: Part,
        list: Vec<f64>,
    }

    #[derive(Default)]
    struct Part {
        a: f64,
        b: [f64; 3],
    }

    fn written(place: &Place, value: f64) -> Model {
        let mut model = Model { list: vec![0.0; 2], ..Model::default() };
        // SAFETY: places of this model, where numbers are.
        unsafe { *place.of(ptr::from_mut(&mut model).cast()).cast() = value };
        assert_eq!(model.first, 0);
        model
    }

    #[test]
    fn every_way_leads_to_the_field() {
        let captured = 1;
        let of_list = Place::array(|m: &mut Model| &mut m.list);
        let a = Place::by(|m: &mut Model| &mut m.part).then(|part: &mut Part| &mut part.a);
        assert_eq!(written(&field!(Model, part.a).place(), 1.0).part.a, 1.0);
        assert_eq!(written(&field!(Model, part.b).place().element(2, 8), 2.0).part.b, [0.0, 0.0, 2.0]);
        assert_eq!(written(&Place::by(|m: &mut Model| &mut m.part.a), 3.0).part.a, 3.0);
        assert_eq!(written(&Place::by(move |m: &mut Model| &mut m.part.b[captured]), 4.0).part.b, [0.0, 4.0, 0.0]);
        assert_eq!(written(&of_list.element(1, 8), 5.0).list, [0.0, 5.0]);
        let part = mem::offset_of!(Model, part);
        assert_eq!(written(&field!(Part, a).place().behind(part), 1.0).part.a, 1.0);
        let of_part = Place::array(|part: &mut Part| &mut part.b).behind(part);
        assert_eq!(written(&of_part.element(2, 8), 2.0).part.b, [0.0, 0.0, 2.0]);
        assert_eq!(written(&a, 6.0).part.a, 6.0);
    }

    #[test]
    fn only_fields_have_an_offset() {
        assert_eq!(field!(Model, part).place().offset(), Some(mem::offset_of!(Model, part)));
        assert_eq!(field!(Model, part).place().then(|part: &mut Part| &mut part.a).offset(), None);
        assert_eq!(Place::by(|m: &mut Model| &mut m.part.a).offset(), None);
    }
}
