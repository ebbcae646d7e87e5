//! What the attributes and comments say.

use proc_macro2::{TokenStream, TokenTree};
use syn::meta::ParseNestedMeta;
use syn::spanned::Spanned;
use syn::{Attribute, Data, DeriveInput, Error, Expr, ExprLit, Fields, Ident, Lit, LitStr, Meta, Result, Token, Type};

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

/// What a field is to the outside.
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

    /// What may stand in the parentheses.
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
        match read_field(field) {
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

fn read_field(field: &syn::Field) -> Result<Field> {
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
    let mut read = Field {
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

impl Field {
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

/// What follows the `=`, up to the next comma: an expression, which the compiler will read, so that syn need not.
fn expression(meta: &ParseNestedMeta<'_>) -> Result<TokenStream> {
    let input = meta.value()?;
    let mut tokens = TokenStream::new();
    while !input.is_empty() && !input.peek(Token![,]) {
        tokens.extend([input.parse::<TokenTree>()?]);
    }
    if tokens.is_empty() { Err(input.error("a value is missing")) } else { Ok(tokens) }
}

/// `(a, b)`: names of fields.
fn fields(meta: &ParseNestedMeta<'_>) -> Result<Vec<Ident>> {
    let mut found = Vec::new();
    meta.parse_nested_meta(|meta| {
        found.push(meta.path.require_ident()?.clone());
        Ok(())
    })?;
    Ok(found)
}

fn key(meta: &ParseNestedMeta<'_>) -> String {
    meta.path.get_ident().map(Ident::to_string).unwrap_or_default()
}

fn unknown(meta: &ParseNestedMeta<'_>, what: &str, keys: &[&str]) -> Error {
    meta.error(format!("{what} takes {}", keys.join(", ")))
}

/// The comment's first paragraph, in one line.
fn first_paragraph(attributes: &[Attribute]) -> String {
    let lines = attributes.iter().filter_map(|attribute| match &attribute.meta {
        Meta::NameValue(meta) if meta.path.is_ident("doc") => match &meta.value {
            Expr::Lit(ExprLit { lit: Lit::Str(text), .. }) => Some(text.value()),
            _ => None,
        },
        _ => None,
    });
    // An empty line of a comment is an empty attribute, and a block comment one with several lines.
    let lines: Vec<String> = lines.collect::<Vec<_>>().join("\n").lines().map(|line| line.trim().to_owned()).collect();
    let begun = lines.iter().skip_while(|line| line.is_empty());
    let paragraph = begun.take_while(|line| !line.is_empty()).cloned().collect::<Vec<_>>().join(" ");
    // A comment is a sentence, a description a label.
    match paragraph.strip_suffix('.') {
        Some(label) if !label.contains(". ") => label.to_owned(),
        _ => paragraph,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Model> {
        model(&syn::parse_str(text).unwrap())
    }

    #[test]
    fn comments_become_descriptions() {
        let model = read(
            "/// A lag of first order:\n/// T der(y) + y = u.\n///\n/// Exact.\n#[model(stop_time = 2)]\nstruct Lag {
                /// Time constant.\n #[parameter(name = \"T\", unit = \"s\", min = 1e-9, start = 0.5)] time_constant: f64,
                /// A text. And another.\n #[input] r#in: [f64; 2],
                x: f64,
            }",
        );
        let model = model.unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(model.description, "A lag of first order: T der(y) + y = u");
        let said: Vec<_> = model.fields.iter().map(|f| (f.role, f.name.as_str(), f.description.as_str())).collect();
        assert_eq!(
            said,
            [
                (Role::Parameter, "T", "Time constant"),
                (Role::Input, "in[{}]", "A text. And another."),
                (Role::State, "x", "")
            ]
        );
    }

    #[test]
    fn mistakes_are_named() {
        let field = |text: &str| format!("/// A model\nstruct A {{ /// An input\n #[input] u: f64, {text} }}");
        for (text, message) in [
            ("/// A\nenum A { B }".to_owned(), "a model is a struct: its fields are the variables"),
            ("/// A\nstruct A(f64);".to_owned(), "the fields need names, which the variables take"),
            (
                "/// A\nstruct A<T> { t: T }".to_owned(),
                "a generic model has no one description: implement `Declare` by hand",
            ),
            ("struct A { x: f64 }".to_owned(), "say in a comment (`///`) what the model is"),
            (
                "/// A\n#[model(step = 1)] struct A { x: f64 }".to_owned(),
                "a model takes name, description, copyright, start_time, stop_time, step_size, tolerance, \
                 directional_derivatives",
            ),
            (field("#[output] y: f64"), "say in a comment (`///`) what `y` is"),
            (field("/// Y\n#[output] #[input] y: f64"), "`y` is one thing only, and has another attribute already"),
            (
                field("/// K\n#[parameter(units = \"s\")] k: f64"),
                "`#[parameter]` takes start, name, unit, display_degrees, min, max, nominal",
            ),
            (field("#[state(unit = \"s\")] k: f64"), "`#[state]` takes start"),
            (field("/// Y\n#[output(depends_on(v))] y: f64"), "there is no field `v`"),
            (field("/// Y\n#[output(depends_on(u, x))] y: f64, x: f64"), "`x` is no input"),
            (field("/// V\n#[input(ramp = slope)] v: f64"), "there is no field `slope`"),
        ] {
            let error = read(&text).err().unwrap_or_else(|| panic!("{text}"));
            assert_eq!(error.to_string(), message);
        }
        let two = read("/// A\nstruct A { #[input] u: f64, #[output] y: f64 }").err().unwrap();
        assert_eq!(two.into_iter().count(), 2, "all fields' mistakes are told at once");
    }
}
