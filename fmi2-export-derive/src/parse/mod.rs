//! Reads the attributes and comments.

mod field;
#[cfg(test)]
mod tests;
mod tokens;

use proc_macro2::TokenStream;
use syn::meta::ParseNestedMeta;
use syn::spanned::Spanned;
use syn::{Data, DeriveInput, Error, Fields, Ident, LitStr, Result};

pub use field::{Field, Role};
use tokens::{expression, first_paragraph, key, unknown};

/// The model.
pub struct Model {
    pub ident: Ident,
    pub name: String,
    pub description: String,
    pub copyright: Option<LitStr>,
    pub start_time: Option<TokenStream>,
    pub stop_time: Option<TokenStream>,
    pub step_size: Option<TokenStream>,
    pub tolerance: Option<TokenStream>,
    pub directional_derivatives: bool,
    pub fields: Vec<Field>,
}

const MODEL_KEYS: &[&str] = &[
    "name",
    "description",
    "copyright",
    "start_time",
    "stop_time",
    "step_size",
    "tolerance",
    "directional_derivatives",
];

/// Reads the struct.
pub fn model(input: &DeriveInput) -> Result<Model> {
    let Data::Struct(data) = &input.data else {
        return Err(Error::new(input.ident.span(), "a model is a struct: its fields are the variables"));
    };
    let Fields::Named(fields) = &data.fields else {
        return Err(Error::new(input.ident.span(), "the fields need names, which the variables take"));
    };
    if !input.generics.params.is_empty() {
        let message = "a generic model has no one description: implement `Declare` by hand";
        return Err(Error::new(input.generics.span(), message));
    }
    let mut model = Model {
        ident: input.ident.clone(),
        name: input.ident.to_string(),
        description: first_paragraph(&input.attrs),
        copyright: None,
        start_time: None,
        stop_time: None,
        step_size: None,
        tolerance: None,
        directional_derivatives: false,
        fields: Vec::new(),
    };
    for attribute in input.attrs.iter().filter(|attribute| attribute.path().is_ident("model")) {
        attribute.parse_nested_meta(|meta| model.read(&meta))?;
    }
    if model.description.is_empty() {
        return Err(Error::new(input.ident.span(), "say in a comment (`///`) what the model is"));
    }
    let mut errors: Option<Error> = None;
    for field in &fields.named {
        match Field::of(field) {
            Ok(field) => model.fields.push(field),
            Err(error) => match &mut errors {
                Some(errors) => errors.combine(error),
                None => errors = Some(error),
            },
        }
    }
    if let Some(errors) = errors {
        return Err(errors);
    }
    model.check_references()?;
    Ok(model)
}

impl Model {
    fn read(&mut self, meta: &ParseNestedMeta<'_>) -> Result<()> {
        let text = || meta.value()?.parse::<LitStr>();
        let expression = || expression(meta).map(Some);
        match key(meta).as_str() {
            "name" => self.name = text()?.value(),
            "description" => self.description = text()?.value(),
            "copyright" => self.copyright = Some(text()?),
            "start_time" => self.start_time = expression()?,
            "stop_time" => self.stop_time = expression()?,
            "step_size" => self.step_size = expression()?,
            "tolerance" => self.tolerance = expression()?,
            "directional_derivatives" => self.directional_derivatives = true,
            _ => return Err(unknown(meta, "a model", MODEL_KEYS)),
        }
        Ok(())
    }

    /// The field of a name.
    pub fn field(&self, ident: &Ident) -> Option<&Field> {
        self.fields.iter().find(|field| field.ident == *ident)
    }

    /// Fields that name others name those that are there, and are inputs.
    fn check_references(&self) -> Result<()> {
        for field in &self.fields {
            for input in field.depends_on.iter().chain(&field.depends_linearly_on).chain(&field.starts_from) {
                match self.field(input) {
                    Some(named) if named.role == Role::Input => {}
                    Some(_) => return Err(Error::new(input.span(), format!("`{input}` is no input"))),
                    None => return Err(Error::new(input.span(), format!("there is no field `{input}`"))),
                }
            }
            for slope in field.ramp.iter().chain(&field.rate) {
                if self.field(slope).is_none() {
                    return Err(Error::new(slope.span(), format!("there is no field `{slope}`")));
                }
            }
        }
        Ok(())
    }
}
