//! A model seen through the declarations of its variables: the only place where their values are touched.

use std::any::{Any, TypeId};
use std::marker::PhantomData;
use std::ptr;

use crate::access::{Access, Narrowed};
use crate::any_model::AnyModel;
use crate::layout::RealSlot;
use crate::pairs::Two;
use crate::place::Place;
use crate::variable::Variable;

/// An evaluation of a model of some type: see [`Declarations`](crate::declarations::Declarations).
pub(crate) type Evaluate = unsafe fn(*mut ());

/// The way to an array of numbers, of a model of some type.
pub(crate) type NumbersOf = dyn Fn(*mut ()) -> *mut [f64] + Send + Sync;

/// What was declared of a model of this type, and what is in it.
#[derive(Clone, Copy)]
pub(crate) struct Declared<'a> {
    pub model: TypeId,
    pub variables: &'a [Variable],
    pub evaluations: &'a [Evaluate],
    /// By value reference.
    pub reals: &'a [RealSlot],
}

/// A model and what was declared of its type.
pub(crate) struct View<'a> {
    declared: Declared<'a>,
    model: *mut (),
    life: PhantomData<&'a mut ()>,
}

/// The value of a variable.
pub(crate) enum Value<'v> {
    Real(f64),
    Integer(Narrowed),
    Enumeration(Narrowed),
    Boolean(bool),
    String(&'v str),
}

impl<'a> View<'a> {
    /// # Panics
    /// If the model is of another type.
    pub fn of(declared: Declared<'a>, model: &'a mut dyn AnyModel) -> Self {
        let any: &dyn Any = model;
        assert!(any.type_id() == declared.model, "variables of another model");
        // SAFETY: it is of this type.
        unsafe { Self::unchecked(declared, model) }
    }

    /// As [`of`](Self::of), for what is called at every step.
    ///
    /// # Safety
    /// The model must be of the type that the declarations are of.
    #[inline]
    pub unsafe fn unchecked(declared: Declared<'a>, model: &'a mut dyn AnyModel) -> Self {
        Self { declared, model: ptr::from_mut(model).cast(), life: PhantomData }
    }

    /// The value at a place of this model.
    ///
    /// # Safety
    /// The place must be one of the declarations', and a value of this type must be there.
    unsafe fn at<T>(&mut self, place: &Place) -> &mut T {
        // SAFETY: the model is of the type that the place was made for, and the view has it alone.
        unsafe { &mut *place.of(self.model).cast() }
    }

    /// The value of a real variable, 0 if there is none of this value reference.
    #[inline]
    pub fn real(&mut self, reference: u32) -> f64 {
        match self.declared.reals.get(reference as usize) {
            // SAFETY: the slot's field is a number at this distance in every model of the type.
            Some(slot) if slot.offset != RealSlot::ELSEWHERE => unsafe {
                *self.model.byte_add(slot.offset as usize).cast()
            },
            Some(slot) => self.distant(slot.variable).map_or(0.0, |value| *value),
            None => 0.0,
        }
    }

    /// Sets a real variable, if there is one of this value reference.
    #[inline]
    pub fn set_real(&mut self, reference: u32, value: f64) {
        match self.declared.reals.get(reference as usize) {
            // SAFETY: as in `real`.
            Some(slot) if slot.offset != RealSlot::ELSEWHERE => unsafe {
                *self.model.byte_add(slot.offset as usize).cast() = value;
            },
            Some(slot) => {
                if let Some(place) = self.distant(slot.variable) {
                    *place = value;
                }
            }
            None => {}
        }
    }

    /// Sets real variables that all have an offset.
    ///
    /// # Safety
    /// Each of them must be there and have one.
    #[inline]
    pub unsafe fn set_near(&mut self, references: &[u32], values: &[f64]) {
        for (reference, value) in references.iter().zip(values) {
            // SAFETY: the caller's promise; the rest as in `real`.
            unsafe {
                let slot = self.declared.reals.get_unchecked(*reference as usize);
                *self.model.byte_add(slot.offset as usize).cast() = *value;
            }
        }
    }

    /// Sets numbers that stand side by side.
    ///
    /// # Safety
    /// So many variables must follow each other in memory from this offset on.
    #[inline]
    pub unsafe fn set_run(&mut self, offset: u32, values: &[f64]) {
        let places = self.model.wrapping_byte_add(offset as usize).cast();
        // SAFETY: the caller's promise.
        unsafe { copy(values.as_ptr(), places, values.len()) };
    }

    /// Reads numbers that stand side by side.
    ///
    /// # Safety
    /// So many variables must follow each other in memory from this offset on, and there must be room for them.
    #[inline]
    pub unsafe fn get_run(&self, offset: u32, values: *mut f64, count: usize) {
        let places = self.model.wrapping_byte_add(offset as usize).cast();
        // SAFETY: the caller's promise.
        unsafe { copy(places, values, count) };
    }

    /// The value of a real variable that has an offset.
    ///
    /// # Safety
    /// There must be one of this value reference.
    #[inline]
    pub unsafe fn near(&self, reference: u32) -> f64 {
        // SAFETY: the caller's promise; the rest as in `real`.
        unsafe {
            let slot = self.declared.reals.get_unchecked(reference as usize);
            *self.model.byte_add(slot.offset as usize).cast()
        }
    }

    /// A real variable that only a function leads to.
    fn distant(&mut self, variable: u32) -> Option<&mut f64> {
        match &self.declared.variables.get(variable as usize)?.access {
            // SAFETY: of the declarations, and of a number.
            Access::Real(place) => Some(unsafe { self.at(place) }),
            _ => None,
        }
    }

    fn variable_of(&self, reference: u32) -> Option<&'a Variable> {
        self.declared.variables.get(self.declared.reals.get(reference as usize)?.variable as usize)
    }

    /// The slope of a real input, if it can have one.
    pub fn ramp(&mut self, reference: u32) -> Option<&mut f64> {
        // SAFETY: of the declarations, and of a number.
        self.variable_of(reference)?.ramp.as_ref().map(|place| unsafe { self.at(place) })
    }

    /// The time derivative of a real output, if it has one.
    pub fn rate(&mut self, reference: u32) -> Option<f64> {
        // SAFETY: of the declarations, and of a number.
        self.variable_of(reference)?.rate.as_ref().map(|(place, _)| *unsafe { self.at::<f64>(place) })
    }

    /// A number at a place of the declarations that no variable is at.
    ///
    /// # Safety
    /// It must be one of these declarations', and a number must be there.
    pub unsafe fn number(&mut self, place: &Place) -> &mut f64 {
        // SAFETY: the caller's promise.
        unsafe { self.at(place) }
    }

    /// The value of a variable of any type.
    pub fn value(&mut self, variable: usize) -> Value<'_> {
        // SAFETY: each place is of the declarations, and its type what the access says.
        unsafe {
            match &self.declared.variables[variable].access {
                Access::Real(place) => Value::Real(*self.at(place)),
                Access::Integer(place, whole) => Value::Integer((whole.get)(place.of(self.model))),
                Access::Enumeration(place, whole, _) => Value::Enumeration((whole.get)(place.of(self.model))),
                Access::Boolean(place) => Value::Boolean(*self.at(place)),
                Access::String(place) => Value::String(self.at::<String>(place)),
            }
        }
    }

    /// Sets an integer or an enumeration to what it can be.
    pub fn set_integer(&mut self, variable: usize, value: i32) {
        match &self.declared.variables[variable].access {
            // SAFETY: as in `value`.
            Access::Integer(place, whole) | Access::Enumeration(place, whole, _) => unsafe {
                (whole.set)(place.of(self.model), value);
            },
            _ => {}
        }
    }

    /// Sets a Boolean.
    pub fn set_boolean(&mut self, variable: usize, value: bool) {
        if let Access::Boolean(place) = &self.declared.variables[variable].access {
            // SAFETY: as in `value`.
            *unsafe { self.at(place) } = value;
        }
    }

    /// Sets a text.
    pub fn set_string(&mut self, variable: usize, value: &str) {
        if let Access::String(place) = &self.declared.variables[variable].access {
            // SAFETY: as in `value`.
            value.clone_into(unsafe { self.at::<String>(place) });
        }
    }

    /// Runs the one evaluation that has this bit.
    ///
    /// # Safety
    /// There must be one.
    #[inline]
    pub unsafe fn evaluate_one(&mut self, todo: u64) {
        // SAFETY: the caller's promise; of the declarations.
        unsafe { self.declared.evaluations.get_unchecked(todo.trailing_zeros() as usize)(self.model) };
    }

    /// Runs evaluations, a bit each.
    #[inline]
    pub fn evaluate(&mut self, mut todo: u64) {
        while todo != 0 {
            let index = todo.trailing_zeros() as usize;
            if let Some(evaluation) = self.declared.evaluations.get(index) {
                // SAFETY: of the declarations.
                unsafe { evaluation(self.model) };
            }
            todo &= todo - 1;
        }
    }

    /// The elements of an array of numbers.
    ///
    /// # Safety
    /// It must be one of these declarations'.
    pub unsafe fn numbers(self, array: &NumbersOf) -> &'a [f64] {
        // SAFETY: the caller's promise; nobody else has the model for as long.
        unsafe { &*array(self.model) }
    }
}

/// Copies numbers.
///
/// # Safety
/// So many must be readable, and so many writable.
#[inline]
unsafe fn copy(from: *const f64, to: *mut f64, count: usize) {
    let Some(last) = count.checked_sub(1) else { return };
    let mut i = 0;
    // SAFETY: the caller's promise.
    unsafe {
        while i < last {
            Two::read(from.add(i)).write(to.add(i));
            i += 2;
        }
        if i == last {
            *to.add(i) = *from.add(i);
        }
    }
}
