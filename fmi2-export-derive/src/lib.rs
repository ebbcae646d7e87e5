#![doc = include_str!("../README.md")]

mod expand;
mod parse;

use proc_macro::TokenStream;
use quote::quote;
use syn::{DeriveInput, parse_macro_input};

/// Declares the fields of a struct as variables, and gives it a `Default` with their start values.
///
/// The first paragraph of the struct's comment is the model's description, that of a field the variable's. Everything that
/// Cargo knows of the crate (version, authors, licence) is taken from there.
///
/// | on a field | it is |
/// |---|---|
/// | `#[input]` | an input |
/// | `#[output]`, `#[local]` | an output or a local variable, up to date after the step or computed by `Model::outputs` |
/// | `#[parameter]` | a parameter that is fixed once the simulation runs |
/// | `#[tunable]` | a parameter that may change between steps |
/// | `#[state]`, or nothing | no variable: state, slopes of inputs, and what else the model keeps |
///
/// | in their parentheses | on | means |
/// |---|---|---|
/// | `start = 0.5` | all | the value in `Default`; without it that of the field's type, such as 0 |
/// | `name = "T"` | variables | the name, if it is not the field's |
/// | `unit = "N.m"` | numbers | a product of SI units, see `Unit` |
/// | `display_degrees` | angles, and rates of them | tools show degrees |
/// | `min = 0.0`, `max = 1.0` | numbers | the admissible range |
/// | `nominal = 100.0` | numbers | the order of magnitude |
/// | `discrete` | inputs, outputs | a number that changes at communication points only |
/// | `ramp = field` | inputs | the field with the slope over the next step |
/// | `depends_on(field, …)` | outputs | the inputs it follows at once, without a step |
/// | `depends_linearly_on(field, …)` | outputs | the same, linearly and with a fixed factor |
/// | `starts_from(field, …)` | outputs | the inputs that its initial value follows from through `Model::initialize` |
/// | `rate = field` | outputs | the field in which `Model::rates` leaves its time derivative |
///
/// An array is as many variables, `field[1]`, `field[2]`, …; in its name and description `{}` stands for the number.
///
/// On the struct, `#[model(…)]` says `name = "Lag"` if it is not the struct's, `description = "…"`, `copyright = "…"`,
/// `start_time`, `stop_time`, `step_size` and `tolerance` of the default experiment, and `directional_derivatives` if
/// `Model::directional_derivative` is implemented.
#[proc_macro_derive(Declare, attributes(model, input, output, local, parameter, tunable, state))]
pub fn derive_declare(item: TokenStream) -> TokenStream {
    let input = parse_macro_input!(item as DeriveInput);
    parse::model(&input).map_or_else(syn::Error::into_compile_error, |model| expand::declare(&model)).into()
}

/// Derives all that a model whose variables are fields of one struct needs beside its behaviour: `Clone`, `Serialize` and
/// `Deserialize` for saved states, and [`Declare`](macro@Declare), whose attributes it takes: `#[fmi2_export::model(stop_time =
/// 5.0)]`.
#[proc_macro_attribute]
pub fn model(arguments: TokenStream, item: TokenStream) -> TokenStream {
    let (arguments, item) = (proc_macro2::TokenStream::from(arguments), proc_macro2::TokenStream::from(item));
    let model = if arguments.is_empty() { quote!() } else { quote!(#[model(#arguments)]) };
    quote! {
        #[derive(
            ::core::clone::Clone,
            ::fmi2_export::serde::Serialize,
            ::fmi2_export::serde::Deserialize,
            ::fmi2_export::Declare,
        )]
        #[serde(crate = "fmi2_export::serde")]
        #model
        #item
    }
    .into()
}
