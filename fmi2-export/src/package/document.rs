//! `documentation/index.html`: what the model's author wrote, and a table of the variables.

use crate::Description;

/// Path of the file that becomes the page's body.
pub const CONTENT: &str = "documentation/content.html";

/// The page.
pub fn index(description: &Description, content: &str) -> String {
    let name = description.name;
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>{name}</title>\n</head>\n<body>\n\
         <h1>{name}</h1>\n{content}\n</body>\n</html>\n"
    )
}
