//! The prims of a stage, with their properties.

use std::collections::HashMap;

use nalgebra::Vector3;

use crate::value::{Property, Value};

/// A prim of the composed stage.
#[derive(Debug, Default)]
pub(crate) struct Prim {
    pub(crate) path: String,
    pub(crate) name: String,
    /// The name for people, which need not be an identifier.
    pub(crate) display_name: Option<String>,
    pub(crate) type_name: String,
    /// The applied schemas, with their instances as in `PhysicsDriveAPI:angular`.
    pub(crate) schemas: Vec<String>,
    pub(crate) parent: Option<usize>,
    pub(crate) children: Vec<usize>,
    pub(crate) properties: HashMap<String, Property>,
}

impl Prim {
    /// The value of a property, which counts as used.
    pub(crate) fn value(&self, name: &str) -> Option<&Value> {
        let property = self.properties.get(name)?;
        property.is_used.set(true);
        Some(&property.value)
    }

    pub(crate) fn numbers(&self, name: &str) -> Option<&[f64]> {
        match self.value(name)? {
            Value::Numbers(numbers) => Some(numbers),
            _ => None,
        }
    }

    pub(crate) fn number(&self, name: &str) -> Option<f64> {
        match self.numbers(name)? {
            [number] => Some(*number),
            _ => None,
        }
    }

    /// The first of these properties that is present.
    pub(crate) fn first_number(&self, names: &[&str]) -> Option<f64> {
        let numbers: Vec<f64> = names.iter().filter_map(|name| self.number(name)).collect();
        numbers.first().copied()
    }

    pub(crate) fn vector(&self, name: &str) -> Option<Vector3<f64>> {
        match self.numbers(name)? {
            &[x, y, z] => Some(Vector3::new(x, y, z)),
            _ => None,
        }
    }

    pub(crate) fn flag(&self, name: &str) -> Option<bool> {
        self.number(name).map(|number| number != 0.0)
    }

    pub(crate) fn words(&self, name: &str) -> Option<&[String]> {
        match self.value(name)? {
            Value::Words(words) => Some(words),
            _ => None,
        }
    }

    pub(crate) fn word(&self, name: &str) -> Option<&str> {
        match self.words(name)? {
            [word] => Some(word),
            _ => None,
        }
    }

    pub(crate) fn targets(&self, name: &str) -> &[String] {
        match self.value(name) {
            Some(Value::Targets(targets)) => targets,
            _ => &[],
        }
    }

    /// Whether the schema is applied.
    pub(crate) fn has(&self, schema: &str) -> bool {
        self.schemas.iter().any(|applied| applied == schema)
    }

    /// The name that people see, or the name.
    pub(crate) fn shown_name(&self) -> &str {
        self.display_name.as_deref().filter(|name| !name.is_empty()).unwrap_or(&self.name)
    }
}

/// The composed stage.
#[derive(Debug)]
pub(crate) struct Scene {
    /// The first is the root, whose path is `/`. Parents precede their children.
    pub(crate) prims: Vec<Prim>,
    pub(crate) index: HashMap<String, usize>,
    /// \[m\] per unit of length.
    pub(crate) meters: Option<f64>,
    /// \[kg\] per unit of mass.
    pub(crate) kilograms: Option<f64>,
    pub(crate) up: Option<String>,
    pub(crate) default_prim: Option<String>,
    /// The files that were read, as the resolver names them.
    pub(crate) files: Vec<std::path::PathBuf>,
    /// Parts of the composition that failed.
    pub(crate) faults: Vec<String>,
}

impl Scene {
    /// The prims from a prim to the root.
    pub(crate) fn upward(&self, start: usize) -> impl Iterator<Item = usize> {
        core::iter::successors(Some(start), |&prim| self.prims[prim].parent)
    }

    /// The prim at a path, or that of a property's path.
    pub(crate) fn find(&self, path: &str) -> Option<usize> {
        let prim = path.split('.').next().unwrap_or(path);
        self.index.get(prim).copied()
    }
}
