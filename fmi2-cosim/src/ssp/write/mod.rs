//! SSD and SSV documents as XML. The same values always give the same text.

mod parameters;

use super::namespace;
use super::structure::{
    Binding, ComponentElement, Connection, Connector, DefaultExperiment, End, Extent, Origin, SystemElement,
    SystemStructure, Values,
};
use super::xml::{Attributes, Xml, number};
use fmi2_import::description::BaseType;
pub use parameters::parameter_set;
use parameters::{parameter_mapping, set_attributes, set_content, units};

/// The text of an `.ssd` file.
#[must_use]
pub fn system_structure(structure: &SystemStructure) -> String {
    let mut root: Attributes<'_> = vec![
        ("xmlns:ssc", namespace::SSC.into()),
        ("xmlns:ssd", namespace::SSD.into()),
        ("xmlns:ssv", namespace::SSV.into()),
        ("xmlns:oms", namespace::OMS.into()),
        ("xmlns:osp", namespace::OSP.into()),
        ("version", "1.0".into()),
        ("name", structure.name.clone()),
    ];
    describe(&mut root, structure.description.as_ref());
    credit(&mut root, &structure.origin);
    Xml::document("ssd:SystemStructureDescription", &root, |xml| {
        system(xml, &structure.system, structure.experiment);
        units(xml, "ssd:Units", &structure.units);
        experiment(xml, structure.experiment);
    })
}

fn describe(attributes: &mut Attributes<'_>, description: Option<&String>) {
    attributes.extend(description.map(|text| ("description", text.clone())));
}

fn credit(attributes: &mut Attributes<'_>, origin: &Origin) {
    attributes.extend(origin.license.clone().map(|text| ("license", text)));
    attributes.extend(origin.generation_tool.clone().map(|text| ("generationTool", text)));
}

fn system(xml: &mut Xml, system: &SystemElement, experiment: DefaultExperiment) {
    let mut attributes = vec![("name", system.name.clone())];
    describe(&mut attributes, system.description.as_ref());
    xml.element("ssd:System", &attributes, |xml| {
        connectors(xml, &system.connectors);
        bindings(xml, &system.bindings);
        if !system.components.is_empty() {
            xml.element("ssd:Elements", &[], |xml| {
                for each in &system.components {
                    component(xml, each);
                }
            });
        }
        if !system.connections.is_empty() {
            xml.element("ssd:Connections", &[], |xml| {
                for connection in &system.connections {
                    xml.empty("ssd:Connection", &connection_attributes(connection));
                }
            });
        }
        if let Some(canvas) = &system.canvas {
            xml.empty("ssd:SystemGeometry", &corners(canvas));
        }
        if let Some(step) = experiment.step {
            annotation(xml, "org.openmodelica", |xml| oms_master(xml, step, experiment.tolerance));
        }
    });
}

/// `OMSimulator` finds here that the system is stepped by a co-simulation master, and how.
fn oms_master(xml: &mut Xml, step: f64, tolerance: Option<f64>) {
    xml.element("oms:Annotations", &[], |xml| {
        xml.element("oms:SimulationInformation", &[], |xml| {
            let mut attributes = vec![
                ("description", "oms-ma".into()),
                ("stepSize", format!("{step}")),
                ("absoluteTolerance", "0.0001".into()),
            ];
            attributes.extend(tolerance.map(|tolerance| ("relativeTolerance", format!("{tolerance}"))));
            xml.empty("oms:FixedStepMaster", &attributes);
        });
    });
}

fn experiment(xml: &mut Xml, experiment: DefaultExperiment) {
    let mut attributes = Vec::new();
    attributes.extend(experiment.start.map(|time| ("startTime", number(time))));
    attributes.extend(experiment.stop.map(|time| ("stopTime", number(time))));
    let Some(step) = experiment.step else {
        if !attributes.is_empty() {
            xml.empty("ssd:DefaultExperiment", &attributes);
        }
        return;
    };
    xml.element("ssd:DefaultExperiment", &attributes, |xml| {
        annotation(xml, "com.opensimulationplatform", |xml| {
            xml.element("osp:Algorithm", &[], |xml| {
                xml.empty("osp:FixedStepAlgorithm", &[("baseStepSize", format!("{step}"))]);
            });
        });
    });
}

fn annotation(xml: &mut Xml, kind: &str, content: impl FnOnce(&mut Xml)) {
    xml.element("ssd:Annotations", &[], |xml| xml.element("ssc:Annotation", &[("type", kind.into())], content));
}

fn component(xml: &mut Xml, component: &ComponentElement) {
    let mut attributes = vec![
        ("name", component.name.clone()),
        ("type", "application/x-fmu-sharedlibrary".into()),
        ("source", component.source.clone()),
        ("implementation", "CoSimulation".into()),
    ];
    describe(&mut attributes, component.description.as_ref());
    xml.element("ssd:Component", &attributes, |xml| {
        connectors(xml, &component.connectors);
        if let Some(extent) = &component.extent {
            xml.empty("ssd:ElementGeometry", &corners(extent));
        }
        bindings(xml, &component.bindings);
    });
}

fn corners(extent: &Extent) -> Attributes<'static> {
    vec![
        ("x1", number(extent.low.x)),
        ("y1", number(extent.low.y)),
        ("x2", number(extent.high.x)),
        ("y2", number(extent.high.y)),
    ]
}

fn connectors(xml: &mut Xml, connectors: &[Connector]) {
    if connectors.is_empty() {
        return;
    }
    xml.element("ssd:Connectors", &[], |xml| {
        for connector in connectors {
            let mut attributes = vec![("name", connector.name.clone()), ("kind", connector.kind.name().into())];
            describe(&mut attributes, connector.description.as_ref());
            xml.element("ssd:Connector", &attributes, |xml| {
                // An enumeration would need its definition in the document; the FMU's variable has the type anyway.
                if let Some(base_type) = connector.base_type.filter(|base_type| *base_type != BaseType::Enumeration) {
                    let unit = connector.unit.iter().map(|unit| ("unit", unit.clone()));
                    xml.empty(&format!("ssc:{}", base_type.name()), &unit.collect::<Vec<_>>());
                }
                if let Some(position) = connector.position {
                    let attributes = [("x", number(position.x)), ("y", number(position.y))];
                    xml.empty("ssd:ConnectorGeometry", &attributes);
                }
            });
        }
    });
}

fn connection_attributes(connection: &Connection) -> Attributes<'static> {
    let mut attributes = Vec::new();
    let mut end = |end: &End, element, connector| {
        attributes.extend(end.element.clone().map(|name| (element, name)));
        attributes.push((connector, end.connector.clone()));
    };
    end(&connection.start, "startElement", "startConnector");
    end(&connection.end, "endElement", "endConnector");
    if connection.suppress_unit_conversion {
        attributes.push(("suppressUnitConversion", "true".into()));
    }
    attributes
}

fn bindings(xml: &mut Xml, bindings: &[Binding]) {
    if bindings.is_empty() {
        return;
    }
    xml.element("ssd:ParameterBindings", &[], |xml| {
        for binding in bindings {
            let mut attributes = Vec::new();
            if let Values::File(source) = &binding.values {
                attributes.push(("source", source.clone()));
            }
            if !binding.prefix.is_empty() {
                attributes.push(("prefix", binding.prefix.clone()));
            }
            if matches!((&binding.values, &binding.mapping), (Values::File(_), None)) {
                xml.empty("ssd:ParameterBinding", &attributes);
                continue;
            }
            xml.element("ssd:ParameterBinding", &attributes, |xml| {
                if let Values::Inline(set) = &binding.values {
                    xml.element("ssd:ParameterValues", &[], |xml| {
                        xml.element("ssv:ParameterSet", &set_attributes(set), |xml| set_content(xml, set));
                    });
                }
                if let Some(mapping) = &binding.mapping {
                    parameter_mapping(xml, mapping);
                }
            });
        }
    });
}
