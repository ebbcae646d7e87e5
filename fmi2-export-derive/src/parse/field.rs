//! The fields: their roles, and the contents of their attributes.

use proc_macro2::TokenStream;
use syn::meta::ParseNestedMeta;
use syn::spanned::Spanned;
use syn::{Attribute, Error, Ident, LitStr, Meta, Result, Type};

use super::tokens::{expression, fields, first_paragraph, key, unknown};

/// A field of its struct.
pub struct Field {
    pub ident: Ident,
    pub ty: Type,
    pub role: Role,
    /// The variable's name; a pattern with `{}` for an array.
    pub name: String,
    pub description: String,
    pub start: Option<TokenStream>,
    pub unit: Option<LitStr>,
    pub display_degrees: bool,
    pub min: Option<TokenStream>,
    pub max: Option<TokenStream>,
    pub nominal: Option<TokenStream>,
    pub discrete: bool,
    pub ramp: Option<Ident>,
    pub rate: Option<Ident>,
    pub depends_on: Vec<Ident>,
    pub depends_linearly_on: Vec<Ident>,
    pub starts_from: Vec<Ident>,
}

/// The role of a field in the interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    Input,
    Output,
    Local,
    Parameter,
    Tunable,
    /// Nothing.
    State,
}

impl Role {
    const ALL: [(&str, Self); 6] = [
        ("input", Self::Input),
        ("output", Self::Output),
        ("local", Self::Local),
        ("parameter", Self::Parameter),
        ("tunable", Self::Tunable),
        ("state", Self::State),
    ];

    fn of(attribute: &Attribute) -> Option<Self> {
        Self::ALL.iter().find(|(name, _)| attribute.path().is_ident(name)).map(|(_, role)| *role)
    }

    fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, role)| *role == self).map_or("", |(name, _)| name)
    }

    /// The keys that its parentheses may contain.
    fn keys(self) -> &'static [&'static str] {
        match self {
            Self::State => &["start"],
            Self::Parameter | Self::Tunable => &["start", "name", "unit", "display_degrees", "min", "max", "nominal"],
            Self::Input => &["start", "name", "unit", "display_degrees", "min", "max", "nominal", "discrete", "ramp"],
            Self::Output | Self::Local => &[
                "start",
                "name",
                "unit",
                "display_degrees",
                "min",
                "max",
                "nominal",
                "discrete",
                "depends_on",
                "depends_linearly_on",
                "starts_from",
                "rate",
            ],
        }
    }

    pub fn is_computed(self) -> bool {
        matches!(self, Self::Output | Self::Local)
    }
}

impl Field {
    /// Reads a field.
    pub(super) fn of(field: &syn::Field) -> Result<Self> {
        let Some(ident) = field.ident.clone() else {
            return Err(Error::new(field.span(), "the field needs a name"));
        };
        let mut roles = field.attrs.iter().filter_map(|attribute| Some((attribute, Role::of(attribute)?)));
        let (attribute, role) = roles.next().unzip();
        if let Some((second, _)) = roles.next() {
            return Err(Error::new(
                second.span(),
                format!("`{ident}` is one thing only, and has another attribute already"),
            ));
        }
        let role = role.unwrap_or(Role::State);
        let name = ident.to_string();
        let mut read = Self {
            name: name.strip_prefix("r#").unwrap_or(&name).to_owned(),
            ident,
            ty: field.ty.clone(),
            role,
            description: first_paragraph(&field.attrs),
            start: None,
            unit: None,
            display_degrees: false,
            min: None,
            max: None,
            nominal: None,
            discrete: false,
            ramp: None,
            rate: None,
            depends_on: Vec::new(),
            depends_linearly_on: Vec::new(),
            starts_from: Vec::new(),
        };
        if let Some(attribute) = attribute.filter(|attribute| !matches!(attribute.meta, Meta::Path(_))) {
            attribute.parse_nested_meta(|meta| read.read(&meta))?;
        }
        if role != Role::State && read.description.is_empty() {
            return Err(Error::new(read.ident.span(), format!("say in a comment (`///`) what `{}` is", read.ident)));
        }
        if read.is_array() && !read.name.contains("{}") {
            read.name.push_str("[{}]");
        }
        Ok(read)
    }

    pub fn is_array(&self) -> bool {
        matches!(self.ty, Type::Array(_))
    }

    fn read(&mut self, meta: &ParseNestedMeta<'_>) -> Result<()> {
        let key = key(meta);
        if !self.role.keys().contains(&key.as_str()) {
            return Err(unknown(meta, &format!("`#[{}]`", self.role.name()), self.role.keys()));
        }
        let expression = || expression(meta).map(Some);
        match key.as_str() {
            "start" => self.start = expression()?,
            "name" => self.name = meta.value()?.parse::<LitStr>()?.value(),
            "unit" => self.unit = Some(meta.value()?.parse()?),
            "display_degrees" => self.display_degrees = true,
            "min" => self.min = expression()?,
            "max" => self.max = expression()?,
            "nominal" => self.nominal = expression()?,
            "discrete" => self.discrete = true,
            "ramp" => self.ramp = Some(meta.value()?.parse()?),
            "rate" => self.rate = Some(meta.value()?.parse()?),
            "depends_on" => self.depends_on = fields(meta)?,
            "depends_linearly_on" => self.depends_linearly_on = fields(meta)?,
            _ => self.starts_from = fields(meta)?,
        }
        Ok(())
    }
}
