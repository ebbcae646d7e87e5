//! The macro that turns a crate into an FMU's library.

/// Defines the C functions of FMI 2.0, for co-simulation and model exchange, in the crate it is used in, which must be a `cdylib`, and a
/// static `FMUS` that tells the packaging program which models there are.
///
/// Use it once, with one model or several: they share the library, and `fmi2Instantiate` tells them apart by their GUIDs.
///
/// ```ignore
/// fmi2_export::export!(FirstOrderLag, Integrator);
/// ```
///
/// The models can also be in another crate, which collects them with [`models!`](crate::models):
///
/// ```ignore
/// pub use pump_models::FMUS;
/// fmi2_export::export!(in pump_models);
/// ```
#[macro_export]
macro_rules! export {
    (in $($models:ident)::+) => {
        use $($models)::+::FMUS_SERVED;
        $crate::export_c_functions!(FMUS_SERVED);
    };
    ($($model:ty),+ $(,)?) => {
        $crate::models!(@of ::core::env!("CARGO_PKG_NAME"); $($model),+);
        $crate::export_c_functions!(FMUS_SERVED);
    };
}

/// Collects models whose C functions are defined in another crate, by [`export!`](crate::export). It is told the name of that package,
/// the one that packages.
///
/// Code that depends on a model's type is compiled as this crate is, everything else as it is said for the crates it is from.
/// Models of fast equations have a lot of code that runs once for an instance: declarations, settings, saved states. It is a third
/// shorter if the models are in a crate that is compiled for size (`opt-level = "s"`), and the equations, and the library,
/// in crates that are compiled for speed.
///
/// ```ignore
/// fmi2_export::models!(for "pump-fmu": FirstOrderLag, Integrator);
/// ```
#[macro_export]
macro_rules! models {
    (for $package:literal: $($model:ty),+ $(,)?) => { $crate::models!(@of $package; $($model),+); };
    (@of $package:expr; $($model:ty),+) => {
        #[cfg(panic = "abort")]
        ::core::compile_error!(
            "an FMU must not be built with panic = \"abort\": a panic would end the host; say panic = \"unwind\""
        );

        /// What the C functions know of the models.
        #[doc(hidden)]
        pub static FMUS_SERVED: $crate::Served = $crate::Served::new(&[
            $({
                static EXPORTED: $crate::Exported = $crate::Exported::of::<$model>($crate::fixed_guid(
                    // Set by the packaging: see `identity`.
                    ::core::option_env!("FMI2_EXPORT_GUIDS"),
                    <$model as $crate::Declare>::INFO.name,
                ));
                &EXPORTED
            }),+
        ]);

        /// The models this library serves.
        pub static FMUS: $crate::Library = $crate::Library::new(
            $package,
            &[$($crate::Described::<$model>::MODEL),+],
            &FMUS_SERVED,
        );
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! export_c_functions {
    ($library:ident) => {
        // The names and signatures are those of fmi2Functions.h; what they demand of the host is said in `ffi`.
        #[allow(non_snake_case, missing_docs, clippy::missing_safety_doc)]
        mod fmi2_functions {
            use $crate::ffi::{calls, types::*};
            use ::std::ffi::{c_char, c_int};

            $crate::export_c_functions! { @plain
                fmi2GetTypesPlatform() -> *const c_char = get_types_platform;
                fmi2GetVersion() -> *const c_char = get_version;
            }

            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn fmi2Instantiate(
                instance_name: *const c_char,
                fmu_type: c_int,
                guid: *const c_char,
                resource_location: *const c_char,
                functions: *const CallbackFunctions,
                _visible: Boolean,
                logging_on: Boolean,
            ) -> Component {
                // SAFETY: the host's promise.
                unsafe {
                    calls::instantiate(
                        &super::$library, instance_name, fmu_type, guid, resource_location, functions, logging_on,
                    )
                }
            }

            $crate::export_c_functions! { @unsafe
                fmi2FreeInstance(c: Component) -> () = free_instance;
                fmi2SetDebugLogging(c: Component, on: Boolean, n: usize, categories: *const *const c_char) -> Status
                    = set_debug_logging;
                fmi2SetupExperiment(c: Component, tolerance_defined: Boolean, tolerance: f64, start: f64,
                    stop_defined: Boolean, stop: f64) -> Status = setup_experiment;
                fmi2EnterInitializationMode(c: Component) -> Status = enter_initialization_mode;
                fmi2ExitInitializationMode(c: Component) -> Status = exit_initialization_mode;
                fmi2Terminate(c: Component) -> Status = terminate;
                fmi2Reset(c: Component) -> Status = reset;
                fmi2GetReal(c: Component, vr: *const ValueReference, n: usize, value: *mut f64) -> Status = get_real;
                fmi2GetInteger(c: Component, vr: *const ValueReference, n: usize, value: *mut c_int) -> Status
                    = get_integer;
                fmi2GetBoolean(c: Component, vr: *const ValueReference, n: usize, value: *mut Boolean) -> Status
                    = get_boolean;
                fmi2GetString(c: Component, vr: *const ValueReference, n: usize, value: *mut *const c_char) -> Status
                    = get_string;
                fmi2SetReal(c: Component, vr: *const ValueReference, n: usize, value: *const f64) -> Status = set_real;
                fmi2SetInteger(c: Component, vr: *const ValueReference, n: usize, value: *const c_int) -> Status
                    = set_integer;
                fmi2SetBoolean(c: Component, vr: *const ValueReference, n: usize, value: *const Boolean) -> Status
                    = set_boolean;
                fmi2SetString(c: Component, vr: *const ValueReference, n: usize, value: *const *const c_char) -> Status
                    = set_string;
                fmi2GetFMUstate(c: Component, state: *mut FmuState) -> Status = get_fmu_state;
                fmi2SetFMUstate(c: Component, state: FmuState) -> Status = set_fmu_state;
                fmi2FreeFMUstate(c: Component, state: *mut FmuState) -> Status = free_fmu_state;
                fmi2SerializedFMUstateSize(c: Component, state: FmuState, size: *mut usize) -> Status
                    = serialized_fmu_state_size;
                fmi2SerializeFMUstate(c: Component, state: FmuState, bytes: *mut c_char, size: usize) -> Status
                    = serialize_fmu_state;
                fmi2DeSerializeFMUstate(c: Component, bytes: *const c_char, size: usize, state: *mut FmuState) -> Status
                    = deserialize_fmu_state;
                fmi2GetDirectionalDerivative(c: Component, unknowns: *const ValueReference, n_unknowns: usize,
                    knowns: *const ValueReference, n_knowns: usize, seed: *const f64, value: *mut f64) -> Status
                    = get_directional_derivative;
                fmi2SetRealInputDerivatives(c: Component, vr: *const ValueReference, n: usize, order: *const c_int,
                    value: *const f64) -> Status = set_real_input_derivatives;
                fmi2GetRealOutputDerivatives(c: Component, vr: *const ValueReference, n: usize, order: *const c_int,
                    value: *mut f64) -> Status = get_real_output_derivatives;
                fmi2DoStep(c: Component, time: f64, size: f64, no_set_state_before: Boolean) -> Status = do_step;
                fmi2CancelStep(c: Component) -> Status = cancel_step;
                fmi2GetStatus(c: Component, kind: c_int, value: *mut c_int) -> Status = get_status;
                fmi2GetRealStatus(c: Component, kind: c_int, value: *mut f64) -> Status = get_real_status;
                fmi2GetIntegerStatus(c: Component, kind: c_int, value: *mut c_int) -> Status = get_integer_status;
                fmi2GetBooleanStatus(c: Component, kind: c_int, value: *mut Boolean) -> Status = get_boolean_status;
                fmi2GetStringStatus(c: Component, kind: c_int, value: *mut *const c_char) -> Status
                    = get_string_status;
                fmi2EnterEventMode(c: Component) -> Status = enter_event_mode;
                fmi2NewDiscreteStates(c: Component, info: *mut EventInfo) -> Status = new_discrete_states;
                fmi2EnterContinuousTimeMode(c: Component) -> Status = enter_continuous_time_mode;
                fmi2CompletedIntegratorStep(c: Component, no_set_state_before: Boolean, enter_event_mode: *mut Boolean,
                    terminate_simulation: *mut Boolean) -> Status = completed_integrator_step;
                fmi2SetTime(c: Component, time: f64) -> Status = set_time;
                fmi2SetContinuousStates(c: Component, x: *const f64, n: usize) -> Status = set_continuous_states;
                fmi2GetDerivatives(c: Component, derivatives: *mut f64, n: usize) -> Status = get_derivatives;
                fmi2GetEventIndicators(c: Component, indicators: *mut f64, n: usize) -> Status = get_event_indicators;
                fmi2GetContinuousStates(c: Component, x: *mut f64, n: usize) -> Status = get_continuous_states;
                fmi2GetNominalsOfContinuousStates(c: Component, nominals: *mut f64, n: usize) -> Status
                    = get_nominals_of_continuous_states;
            }
        }
    };
    (@plain $( $symbol:ident() -> $result:ty = $function:ident; )*) => { $(
        #[unsafe(no_mangle)]
        pub extern "C" fn $symbol() -> $result {
            calls::$function()
        }
    )* };
    (@unsafe $( $symbol:ident($($name:ident: $type:ty),* $(,)?) -> $result:ty = $function:ident; )*) => { $(
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $symbol($($name: $type),*) -> $result {
            // SAFETY: the host's promise.
            unsafe { calls::$function($($name),*) }
        }
    )* };
}
