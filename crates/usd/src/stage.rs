//! Opens a stage, and copies its prims within the limits of all readers.

use std::cell::{Cell, RefCell};
use std::collections::{HashMap, HashSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::mpsc;
use std::time::Duration;

use openusd::{sdf, usd};
use robot_dynamics_xml::{Budget, Resource, excerpt};

use crate::UsdError;
use crate::prim::{Prim, Scene};
use crate::resolver::{BoundedResolver, Shared};
use crate::scan::DEPTH_LIMIT;
use crate::unread::is_physics;
use crate::value::{Property, Value};

/// The stack of the thread that reads \[bytes\]: the parser recurses with the nesting of prims.
const STACK: usize = 1 << 28;

/// The largest sum of the levels of all prims of a small file, with all copies by references. The time to
/// compose a prim grows with its level.
const LEVEL_LIMIT: usize = 40_000;

/// Larger files may have one level more for each of these bytes.
const BYTES_OF_LEVEL: usize = 4;

/// The longest time for a small file. Classes that inherit each other can take a time that doubles with each
/// level, in one call of openusd that cannot be interrupted.
const PATIENCE: Duration = Duration::from_secs(60);

/// Larger files may take longer: 100 s for each MB.
const MICROSECONDS_OF_BYTE: u64 = 100;

/// The largest array of a prim without a collision shape, except of physics: others are coordinates for
/// pictures.
const SHORT: usize = 64;

/// Where the files are.
#[derive(Debug, Clone)]
pub(crate) struct Source {
    pub(crate) main: PathBuf,
    pub(crate) content: Vec<u8>,
    pub(crate) root: Option<PathBuf>,
    pub(crate) in_memory: Option<Vec<(PathBuf, Vec<u8>)>>,
}

/// Reads all prims, in a thread of its own.
pub(crate) fn read(source: Source) -> Result<Scene, UsdError> {
    let bad = |reason: &str| UsdError::BadFile { reason: reason.to_owned() };
    let patience = PATIENCE + Duration::from_micros(source.content.len() as u64 * MICROSECONDS_OF_BYTE);
    let (send, receive) = mpsc::channel();
    // A panic of the parser ends this thread only.
    let run = move || {
        let result = catch_unwind(AssertUnwindSafe(|| open(source)));
        // After the time is over, nobody receives the result.
        send.send(result).ok();
    };
    let thread = std::thread::Builder::new().name("usd".into()).stack_size(STACK).spawn(run);
    thread.map_err(|error| bad(&format!("no thread to read it: {error}")))?;
    match receive.recv_timeout(patience) {
        Ok(Ok(result)) => result,
        Err(mpsc::RecvTimeoutError::Timeout) => Err(bad(
            "its references and inherits take too long to compose; flatten it with `usdcat --flatten`",
        )),
        Ok(Err(_)) | Err(_) => Err(bad("the parser failed; check the file with `usdchecker`")),
    }
}

fn open(source: Source) -> Result<Scene, UsdError> {
    let shared = Rc::new(RefCell::new(Shared::default()));
    let main = source.main.to_string_lossy().into_owned();
    let resolver = BoundedResolver {
        main: source.main,
        content: source.content,
        root: source.root,
        in_memory: source.in_memory,
        shared: Rc::clone(&shared),
    };
    let bad = |error: &dyn core::fmt::Display| {
        let refused = shared.borrow().refused.first().cloned();
        UsdError::BadFile { reason: refused.unwrap_or_else(|| excerpt(&format!("{error:#}"))) }
    };
    let stage = usd::Stage::builder().resolver(resolver).open(&main).map_err(|error| bad(&error))?;
    let mut copy = Copy { stage: &stage, scene: empty(), shared: &shared, levels: Cell::new(0) };
    copy.metadata().map_err(|error| bad(&error))?;
    copy.prims()?;
    let mut scene = copy.scene;
    for error in stage.composition_errors() {
        scene.faults.push(excerpt(&error.to_string()));
    }
    let mut shared = shared.borrow_mut();
    let mut seen = HashSet::new();
    scene.files = shared.files.drain(..).filter(|file| seen.insert(file.clone())).collect();
    scene.faults.append(&mut shared.refused);
    Ok(scene)
}

fn empty() -> Scene {
    Scene {
        prims: Vec::new(),
        index: HashMap::new(),
        meters: None,
        kilograms: None,
        up: None,
        default_prim: None,
        files: Vec::new(),
        faults: Vec::new(),
    }
}

struct Copy<'s> {
    stage: &'s usd::Stage,
    scene: Scene,
    shared: &'s RefCell<Shared>,
    /// The sum of the levels of all prims.
    levels: Cell<usize>,
}

impl Copy<'_> {
    fn metadata(&mut self) -> Result<(), anyhow::Error> {
        let field = |name: &str| -> Result<Option<Value>, anyhow::Error> {
            Ok(self.stage.stage_metadata(name)?.map(Value::of))
        };
        let number = |value: Option<Value>| match value {
            Some(Value::Numbers(numbers)) if numbers.len() == 1 => Some(numbers[0]),
            _ => None,
        };
        self.scene.meters = number(field("metersPerUnit")?);
        self.scene.kilograms = number(field("kilogramsPerUnit")?);
        if let Some(Value::Words(words)) = field("upAxis")? {
            self.scene.up = words.into_iter().next();
        }
        self.scene.default_prim = self.stage.default_prim().map(|name| name.as_str().to_owned());
        Ok(())
    }

    /// Copies all prims that are active, loaded, defined and not abstract, parents first.
    fn prims(&mut self) -> Result<(), UsdError> {
        let root = Prim { path: "/".to_owned(), ..Prim::default() };
        self.scene.index.insert(root.path.clone(), 0);
        self.scene.prims.push(root);
        let mut pending = vec![(sdf::Path::abs_root(), 0)];
        while let Some((path, at)) = pending.pop() {
            let children = self.children(&path, at)?;
            // The stack returns the last first.
            pending.extend(children.into_iter().rev());
        }
        self.sort();
        Ok(())
    }

    /// Copies the children of a prim, and returns those whose children are to be copied.
    fn children(&mut self, path: &sdf::Path, parent: usize) -> Result<Vec<(sdf::Path, usize)>, UsdError> {
        let prim = self.stage.prim(path.clone());
        let bad = |path: &sdf::Path, error: &anyhow::Error| UsdError::BadPrim {
            place: excerpt(path.as_str()),
            reason: excerpt(&format!("{error:#}")),
        };
        let names = prim.child_names().map_err(|error| bad(path, &error))?;
        let mut found = Vec::new();
        for name in names {
            let Ok(child) = path.append_path(name.as_str()) else { continue };
            let copied = self.prim(&child).map_err(|error| match error {
                Failure::Usd(error) => bad(&child, &error),
                Failure::Limit(error) => error,
            })?;
            let Some(mut copied) = copied else { continue };
            let at = self.scene.prims.len();
            copied.parent = Some(parent);
            self.scene.index.insert(copied.path.clone(), at);
            self.scene.prims[parent].children.push(at);
            self.scene.prims.push(copied);
            found.push((child, at));
        }
        Ok(found)
    }

    /// Copies one prim; `None` if it is not part of the scene.
    fn prim(&self, path: &sdf::Path) -> Result<Option<Prim>, Failure> {
        let prim = self.stage.prim(path.clone());
        if !prim.is_active()? || !prim.is_loaded()? || !prim.is_defined()? || prim.is_abstract()? {
            return Ok(None);
        }
        self.charge(Resource::Elements, 1)?;
        let limit = LEVEL_LIMIT + self.shared.borrow().bytes / BYTES_OF_LEVEL;
        self.levels.set(self.levels.get() + path.prim_element_count());
        if self.levels.get() > limit {
            let what = "levels of prims with all copies, for files of this size";
            return Err(Failure::Limit(UsdError::TooMany { what, limit }));
        }
        if path.prim_element_count() > DEPTH_LIMIT {
            let what = "prims inside one another";
            return Err(Failure::Limit(UsdError::TooMany { what, limit: DEPTH_LIMIT }));
        }
        let mut copy = Prim {
            path: path.as_str().to_owned(),
            name: path.name().unwrap_or_default().to_owned(),
            type_name: prim.type_name()?.map(|name| name.as_str().to_owned()).unwrap_or_default(),
            schemas: prim.api_schemas()?.iter().map(|name| name.as_str().to_owned()).collect(),
            ..Prim::default()
        };
        self.charge(Resource::Characters, copy.path.len() + 16 * copy.schemas.len())?;
        let relations: HashSet<String> =
            prim.relationships()?.iter().map(|relation| relation.path().as_str().to_owned()).collect();
        for name in prim.property_names()? {
            let name = name.as_str();
            if is_appearance(name) {
                continue;
            }
            self.charge(Resource::Elements, 1)?;
            let attribute = prim.attribute(name);
            let value = if relations.contains(attribute.path().as_str()) {
                let targets = prim.relationship(name).forwarded_targets()?;
                Value::Targets(targets.iter().map(|target| target.as_str().to_owned()).collect())
            } else {
                let plain = attribute.get::<sdf::Value>()?;
                let value = match plain {
                    Some(value) => Some(value),
                    None => attribute.get_at::<sdf::Value>(usd::TimeCode::new(0.0))?,
                };
                match value.map(Value::of) {
                    Some(value) => value,
                    None => continue,
                }
            };
            if value.len() > SHORT && !copy.has("PhysicsCollisionAPI") && !is_physics(name) {
                continue;
            }
            let resource =
                if matches!(value, Value::Numbers(_)) { Resource::Numbers } else { Resource::Characters };
            self.charge(resource, value.len())?;
            copy.properties.insert(name.to_owned(), Property::new(value));
        }
        copy.display_name = self.display_name(path)?;
        Ok(Some(copy))
    }

    fn display_name(&self, path: &sdf::Path) -> Result<Option<String>, Failure> {
        let value = self.stage.attribute(path.clone()).get_metadata::<sdf::Value>("displayName")?;
        match value.map(Value::of) {
            Some(Value::Words(words)) => Ok(words.into_iter().next()),
            _ => Ok(None),
        }
    }

    fn charge(&self, resource: Resource, count: usize) -> Result<(), Failure> {
        let budget: &mut Budget = &mut self.shared.borrow_mut().budget;
        budget
            .charge(resource, count)
            .map_err(|limit| Failure::Limit(UsdError::TooMany { what: limit.what, limit: limit.limit }))
    }

    /// Renumbers the prims in the order of the file: depth first.
    fn sort(&mut self) {
        let mut order = Vec::with_capacity(self.scene.prims.len());
        let mut stack = vec![0];
        while let Some(at) = stack.pop() {
            order.push(at);
            stack.extend(self.scene.prims[at].children.iter().rev());
        }
        let mut new_index = vec![0; order.len()];
        for (new, &old) in order.iter().enumerate() {
            new_index[old] = new;
        }
        let mut old: Vec<Option<Prim>> =
            core::mem::take(&mut self.scene.prims).into_iter().map(Some).collect();
        for at in order {
            let Some(mut prim) = old[at].take() else { continue };
            prim.parent = prim.parent.map(|parent| new_index[parent]);
            for child in &mut prim.children {
                *child = new_index[*child];
            }
            self.scene.index.insert(prim.path.clone(), self.scene.prims.len());
            self.scene.prims.push(prim);
        }
    }
}

/// A failure of the library, or a limit.
enum Failure {
    Usd(anyhow::Error),
    Limit(UsdError),
}

impl From<anyhow::Error> for Failure {
    fn from(error: anyhow::Error) -> Self {
        Self::Usd(error)
    }
}

/// Properties of pictures, which can be large.
fn is_appearance(name: &str) -> bool {
    name.starts_with("primvars:")
        || name.starts_with("ui:")
        || matches!(name, "normals" | "extent" | "extentsHint" | "velocities" | "accelerations")
}
