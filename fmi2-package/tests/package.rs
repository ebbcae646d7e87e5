//! What the packaging puts into an archive: files at the standard's places, a page that says what the declarations say
//! whatever text they have, a response that is the model's, and errors that say what is wrong with a document.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

use fmi2_export::{Declare, Experiment, Failure, Info, Model, Step, Variables};
use fmi2_package::{Document, File, PackageError, Panel, Response, write};
use quick_xml::Reader;
use quick_xml::events::Event;
use serde::{Deserialize, Serialize};

/// Text that would do harm in a page that does not escape it.
const HOSTILE: &str = "</td><script>alert('1 & 2')</script> \"quoted\" $\\frac$";

fmi2_export::enumeration! {
    /// What to do with <b>text</b>
    enum Mode {
        #[default]
        Keep = "keep <it>": "Keep & show",
        Drop = "drop": "Drop",
    }
}

/// An integrator with a variable of each type.
#[derive(Clone, Serialize, Deserialize)]
struct Hostile {
    u: f64,
    y: f64,
    angle: f64,
    x: f64,
    count: i32,
    flag: bool,
    text: String,
    mode: Mode,
}

impl Default for Hostile {
    fn default() -> Self {
        let text = HOSTILE.into();
        Self { u: 1.5, y: 0.0, angle: 0.0, x: 0.0, count: 3, flag: true, text, mode: Mode::Keep }
    }
}

impl Declare for Hostile {
    const INFO: Info = Info { name: "Hostile", description: HOSTILE, version: "<1>", license: "A & B", ..Info::new() };

    fn variables(variables: &mut Variables<Self>) {
        let outputs = variables.evaluation(|m| (m.y, m.angle) = (m.x, m.x));
        variables.input("u<1>", |m| &mut m.u).unit("V").range(-2.0, 1e7).description(HOSTILE);
        variables.output("y", outputs, |m| &mut m.y).unit("V.s").description("Integral");
        variables
            .output("angle", outputs, |m| &mut m.angle)
            .unit("rad")
            .display_unit("deg", 180.0 / std::f64::consts::PI)
            .description("The same as an angle");
        variables.parameter("count", |m| &mut m.count).range(0.0, 9.0).description("A whole number");
        variables.parameter("flag", |m| &mut m.flag).description("Yes or no");
        variables.parameter("text", |m| &mut m.text).tunable().description("Words");
        variables.parameter("mode", |m| &mut m.mode).description("What to do");
    }
}

impl Model for Hostile {
    fn initialize(&mut self, _: &Experiment) -> Result<(), Failure> {
        self.x = 0.0;
        Ok(())
    }

    fn step(&mut self, step: &mut Step<'_>) -> Result<(), Failure> {
        if self.u > 1e6 {
            return Err(Failure::discard("too much"));
        }
        self.x += self.u * step.size;
        Ok(())
    }
}

fmi2_export::export!(Hostile);

type Files = BTreeMap<String, Vec<u8>>;

/// Packages the model with a document; the archive's bytes and its files.
fn package(document: &Document<'_>) -> Result<(Vec<u8>, Files), PackageError> {
    let model = FMUS.models()[0];
    let folder = tempfile::tempdir().unwrap();
    let path = write(model, &model.description().unwrap(), b"binary", document, folder.path())?;
    let bytes = std::fs::read(&path).unwrap();
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(&bytes)).unwrap();
    let mut files = Files::new();
    for i in 0..archive.len() {
        let mut file = archive.by_index(i).unwrap();
        let mut content = Vec::new();
        file.read_to_end(&mut content).unwrap();
        files.insert(file.name().unwrap().into_owned(), content);
    }
    Ok((bytes, files))
}

fn problem(document: &Document<'_>) -> String {
    package(document).map(|_| ()).expect_err("a problem").to_string()
}

/// The page's element names and its text, as a strict XML reader sees them.
fn read(page: &str) -> (Vec<String>, String) {
    let mut reader = Reader::from_str(page);
    let (mut names, mut text) = (Vec::new(), String::new());
    loop {
        match reader.read_event().expect("well-formed") {
            Event::Eof => return (names, text),
            Event::Start(element) | Event::Empty(element) => {
                assert!(element.attributes().all(|attribute| attribute.is_ok()));
                names.push(element.name().as_ref().to_owned());
            }
            Event::Text(part) => text.push_str(&part),
            Event::GeneralRef(entity) => text.push_str(match &*entity {
                "lt" => "<",
                "gt" => ">",
                "amp" => "&",
                "quot" => "\"",
                "apos" => "'",
                other => panic!("an entity that XML does not know: {other}"),
            }),
            _ => {}
        }
    }
}

const STEP: Response<'static> = Response {
    caption: "A ramp & $u^2$",
    start: &[("count", 2.0), ("flag", 0.0), ("mode", 2.0)],
    inputs: &[("u<1>", |time| time)],
    stop_time: 2.0,
    step_size: 0.5,
    panels: &[Panel { title: "Integral", variables: &["y"] }, Panel { title: "Angle", variables: &["angle"] }],
    beside: &[],
};

#[test]
fn files_are_where_the_standard_wants_them() {
    let document = Document {
        text: "## Figure\n![a figure](figure.svg)",
        icon: b"\x89PNG\r\n\x1a\n...",
        license: "Do as you like.",
        response: Some(STEP),
        files: &[File { path: "documentation/figure.svg", content: b"<svg/>" }],
        ..Document::new()
    };
    let (bytes, files) = package(&document).unwrap();
    assert_eq!(files["model.png"], document.icon);
    assert_eq!(files["documentation/licenses/license.txt"], b"Do as you like.");
    assert_eq!(files["documentation/figure.svg"], b"<svg/>");
    assert_eq!(files["modelDescription.xml"], FMUS.models()[0].description().unwrap().xml.as_bytes());
    assert!(files.keys().any(|path| path.starts_with("binaries/")) && files.contains_key("documentation/index.html"));
    assert_eq!(package(&document).unwrap().0, bytes, "the same input gives the same bytes");
}

#[test]
fn a_page_says_what_is_declared_whatever_text_it_is() {
    let markup = "<script>x</script>\n\nand <i>y</i>";
    for document in [Document::new(), Document { text: markup, license: HOSTILE, ..Document::new() }] {
        let page =
            String::from_utf8(package(&document).unwrap().1.remove("documentation/index.html").unwrap()).unwrap();
        let (names, text) = read(&page);
        assert!(!names.iter().any(|name| ["script", "i", "b", "it", "link"].contains(&name.as_str())), "{names:?}");
        for said in [HOSTILE, "u<1>", "-2 … 1e7", "0 … 9", "What to do with <b>text</b>", "keep <it>", "Keep & show"]
        {
            assert!(text.contains(said), "{said}");
        }
        assert_eq!(text.contains("<script>x</script>"), !document.text.is_empty());
    }
}

#[test]
fn a_response_is_what_the_model_does() {
    let (_, files) = package(&Document { response: Some(STEP), ..Document::new() }).unwrap();
    // Inputs are held over a step: y after n steps of 0.5 s is the sum of 0.5·(0, 0.5, 1, …).
    let results = std::str::from_utf8(&files["documentation/response.csv"]).unwrap();
    assert_eq!(results, "time,\"y\",\"angle\"\n0,0,0\n0.5,0,0\n1,0.25,0.25\n1.5,0.75,0.75\n2,1.5,1.5\n");
    let inputs = std::str::from_utf8(&files["documentation/response_in.csv"]).unwrap();
    assert_eq!(inputs, "time,\"u<1>\"\n0,0\n0.5,0.5\n1,1\n1.5,1.5\n2,2\n");
    let page = std::str::from_utf8(&files["documentation/index.html"]).unwrap();
    let (names, text) = read(page);
    assert_eq!(names.iter().filter(|name| *name == "svg").count(), 2);
    // The angle is drawn in degrees: 1.5 rad are 85.9 deg, so its axis goes to 100.
    assert!(text.contains("Angle (deg)") && text.contains("100"), "{text}");
    assert!(text.contains("--start-values count 2 flag false mode 2 --input-file documentation/response_in.csv"));
}

#[test]
fn a_document_at_odds_with_the_model_is_refused_with_what_to_do() {
    let response = |response: Response<'static>| problem(&Document { response: Some(response), ..Document::new() });
    let unknown = response(Response { start: &[("cuont", 1.0)], ..STEP });
    assert!(unknown.contains("\"cuont\"; did you mean \"count\"?"), "{unknown}");
    let cases = [
        (Response { start: &[("y", 1.0)], ..STEP }, "computed by the model"),
        (Response { start: &[("text", 1.0)], ..STEP }, "is a string"),
        (Response { start: &[("count", 1.5)], ..STEP }, "whole number"),
        (Response { start: &[("count", 99.0)], ..STEP }, "99"),
        (Response { inputs: &[("count", |_| 1.0)], ..STEP }, "no input of type Real"),
        (Response { inputs: &[("u<1>", |_| 9e6)], ..STEP }, "too much"),
        (Response { panels: &[Panel { title: "", variables: &["y", "u<1>"] }], ..STEP }, "another unit"),
        (Response { panels: &[Panel { title: "", variables: &["text"] }], ..STEP }, "cannot be drawn"),
        (Response { panels: &[Panel { title: "", variables: &["y"; 5] }], ..STEP }, "at most four"),
        (Response { step_size: 0.0, ..STEP }, "must be positive"),
        (Response { stop_time: f64::NAN, ..STEP }, "must be positive"),
        (Response { caption: "$\\frac$", ..STEP }, "caption"),
    ];
    for (wrong, expected) in cases {
        let message = response(wrong);
        assert!(message.contains(expected), "{message}");
    }
    assert!(problem(&Document { text: "an $\\frac$", ..Document::new() }).contains("$\\frac$ is not understood"));
    assert!(problem(&Document { icon: b"<svg/>", ..Document::new() }).contains("PNG"));
    assert!(problem(&Document { text: "![](a.svg)", ..Document::new() }).contains("documentation/a.svg"));
    for path in
        ["", "/etc/x", "../x", "a/./b", "a\\b", "modelDescription.xml", "binaries/x.so", "documentation/index.html"]
    {
        let files = [File { path, content: b"" }];
        assert!(problem(&Document { files: &files, ..Document::new() }).contains("path"), "{path}");
    }
}

#[test]
fn a_failed_packaging_leaves_nothing() {
    let model = FMUS.models()[0];
    let description = model.description().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let wrong = Document { icon: b"no", ..Document::new() };
    assert!(write(model, &description, b"", &wrong, folder.path()).is_err());
    assert!(write(model, &description, b"", &Document::new(), Path::new("/nonexistent/folder")).is_err());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
