//! Expands the attributes to the equivalent code of the builder.

use proc_macro2::TokenStream;
use quote::{quote, quote_spanned};
use syn::spanned::Spanned;
use syn::{Ident, LitStr, Type};

use crate::parse::{Field, Model, Role};

/// Implements `Default` and `Declare`.
pub fn declare(model: &Model) -> TokenStream {
    let Model { ident, name, description, .. } = model;
    let starts = model.fields.iter().map(start);
    let copyright = model.copyright.iter().map(|text| quote!(copyright: #text,));
    let experiment = experiment(model);
    let derivatives = model.directional_derivatives;
    let computed = model.fields.iter().any(|field| field.role.is_computed());
    let evaluation =
        computed.then(|| quote!(let outputs = variables.evaluation(<Self as ::fmi2_export::Model>::outputs);));
    let rated = model.fields.iter().any(|field| field.rate.is_some());
    let rates = rated.then(|| quote!(let rates = variables.evaluation(<Self as ::fmi2_export::Model>::rates);));
    let declarations =
        model.fields.iter().filter(|field| field.role != Role::State).map(|field| declaration(model, field));
    quote! {
        #[automatically_derived]
        impl ::core::default::Default for #ident {
            fn default() -> Self {
                Self { #(#starts),* }
            }
        }

        #[automatically_derived]
        impl ::fmi2_export::Declare for #ident {
            const INFO: ::fmi2_export::Info = ::fmi2_export::Info {
                name: #name,
                description: #description,
                #(#copyright)*
                #experiment
                directional_derivatives: #derivatives,
                ..::fmi2_export::cargo_info!()
            };

            fn variables(variables: &mut ::fmi2_export::Variables<Self>) {
                #evaluation
                #rates
                #(#declarations)*
            }
        }
    }
}

/// `field: value`.
fn start(field: &Field) -> TokenStream {
    let Field { ident, ty, start, .. } = field;
    let Some(value) = start else {
        return quote_spanned!(ty.span()=> #ident: ::core::default::Default::default());
    };
    // A text is a `String`, not a `&str`.
    let text = syn::parse2::<LitStr>(value.clone()).map(|text| quote!(::std::string::String::from(#text)));
    let value = text.unwrap_or_else(|_| value.clone());
    quote!(#ident: #value)
}

fn experiment(model: &Model) -> TokenStream {
    let given = [("start_time", &model.start_time), ("stop_time", &model.stop_time), ("step_size", &model.step_size)];
    let given: Vec<TokenStream> = given
        .iter()
        .filter_map(|(key, value)| {
            let key = Ident::new(key, proc_macro2::Span::call_site());
            value.as_ref().map(|value| quote!(#key: (#value) as f64,))
        })
        .chain(model.tolerance.iter().map(|value| quote!(tolerance: ::core::option::Option::Some((#value) as f64),)))
        .collect();
    if given.is_empty() {
        return quote!();
    }
    quote! {
        default_experiment: ::fmi2_export::DefaultExperiment { #(#given)* ..::fmi2_export::Info::new().default_experiment },
    }
}

/// The builder's calls for one variable.
fn declaration(model: &Model, field: &Field) -> TokenStream {
    let Field { ident, name, description, .. } = field;
    let role = match field.role {
        Role::Input => "input",
        Role::Output => "output",
        Role::Local => "local",
        Role::Parameter | Role::Tunable | Role::State => "parameter",
    };
    let method = Ident::new(&format!("{role}_field"), ident.span());
    let evaluation = field.role.is_computed().then(|| quote!(outputs,));
    let place = quote!(::fmi2_export::field!(Self, #ident));
    let mut calls = Vec::new();
    calls.extend((field.role == Role::Tunable).then(|| quote!(.tunable())));
    calls.extend(field.unit.iter().map(|unit| quote!(.unit(#unit))));
    calls.extend(field.display_degrees.then(|| quote!(.display_degrees())));
    if field.min.is_some() || field.max.is_some() {
        let bound =
            |bound: &Option<TokenStream>, none: TokenStream| bound.as_ref().map_or(none, |b| quote!((#b) as f64));
        let min = bound(&field.min, quote!(::core::primitive::f64::NEG_INFINITY));
        let max = bound(&field.max, quote!(::core::primitive::f64::INFINITY));
        calls.push(quote!(.range(#min, #max)));
    }
    calls.extend(field.nominal.iter().map(|nominal| quote!(.nominal((#nominal) as f64))));
    calls.extend(field.discrete.then(|| quote!(.discrete())));
    for (method, inputs) in [
        ("depends_on", &field.depends_on),
        ("depends_linearly_on", &field.depends_linearly_on),
        ("starts_from", &field.starts_from),
    ] {
        let method = Ident::new(method, ident.span());
        let inputs = inputs.iter().filter_map(|input| model.field(input));
        calls.extend(inputs.map(|input| {
            let names = names(input, field);
            quote!(.#method(#names))
        }));
    }
    let slope = Ident::new(if field.is_array() { "ramp_array" } else { "ramp" }, ident.span());
    calls.extend(field.ramp.iter().map(|to| {
        let place = lens(field, to);
        quote!(.#slope(#place))
    }));
    let rate = Ident::new(if field.is_array() { "rate_array" } else { "rate" }, ident.span());
    calls.extend(field.rate.iter().map(|to| {
        let place = lens(field, to);
        quote!(.#rate(rates, #place))
    }));
    quote! {
        variables.#method(#name, #evaluation #place) #(#calls)* .description(#description);
    }
}

/// The way to a field; to all elements of an array.
fn lens(field: &Field, to: &Ident) -> TokenStream {
    if field.is_array() { quote!(|model| &mut model.#to[..]) } else { quote!(|model| &mut model.#to) }
}

/// The names of an input that an output depends on: one array depends on another element by element.
fn names(input: &Field, output: &Field) -> TokenStream {
    let name = &input.name;
    match &input.ty {
        Type::Array(array) if !output.is_array() => {
            let length = &array.len;
            quote!((1..=#length).map(|number| #name.replace("{}", &::std::string::ToString::to_string(&number))))
        }
        _ => quote!([#name]),
    }
}
