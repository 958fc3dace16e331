//! Statistics of robot files, and files with suspicious units.
//!
//! `cargo run --release -p robot-dynamics-urdf --example 06_plausibility -- FILE.urdf …` prints, for all
//! files together, the quantiles of each statistic of `robot_dynamics::plausibility` over the links and over
//! the medians of robots, then the suspicions of each file. The ranges of that module were chosen with this
//! program.

use std::error::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use robot_dynamics::plausibility::{LinkStatistics, RobotStatistics, Suspicion, suspicions};
use robot_dynamics::urdf::LoadOptions;

/// The statistics and suspicions of one file.
pub(crate) struct Judged {
    /// The file.
    pub(crate) path: PathBuf,
    /// Its statistics.
    pub(crate) statistics: RobotStatistics,
    /// Its suspicions.
    pub(crate) suspicions: Vec<Suspicion>,
}

/// Reads a file and checks its units.
///
/// # Errors
///
/// The file is refused.
pub(crate) fn judge(path: &Path) -> Result<Judged, Box<dyn Error>> {
    let robot = robot_dynamics::urdf::load(path, &LoadOptions::default().with_repaired_inertia())?;
    let statistics = RobotStatistics::new(&robot.description);
    let suspicions = suspicions(&robot.description, &robot.angles);
    Ok(Judged { path: path.to_owned(), statistics, suspicions })
}

type Statistic = fn(&LinkStatistics, &RobotStatistics) -> Option<f64>;

/// The statistics with their names.
const STATISTICS: [(&str, Statistic); 6] = [
    ("ellipsoid density [kg/m³]", |link, _| link.ellipsoid_density),
    ("gyration/extent", |link, _| link.gyration_over_extent()),
    ("gyration/size", |link, robot| Some(link.gyration / robot.size).filter(|x| x.is_finite() && *x > 0.0)),
    ("centre/size", |link, robot| Some(link.center_distance / robot.size).filter(|x| x.is_finite())),
    ("mass/extent³ [kg/m³]", |link, _| link.mass_over_cubed_extent()),
    ("shape density [kg/m³]", |link, _| link.shape_density),
];

const QUANTILES: [f64; 9] = [0.0, 0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99, 1.0];

/// The values at [`QUANTILES`].
fn quantiles(mut values: Vec<f64>) -> String {
    values.sort_by(f64::total_cmp);
    // The index is below the number of values.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let at = |part: f64| values.get((part * values.len().saturating_sub(1) as f64).round() as usize);
    let cells = QUANTILES.map(|part| at(part).map_or("-".into(), |value| format!("{value:.2e}")));
    cells.map(|cell| format!("{cell:>10}")).concat()
}

/// The table of all statistics over all files.
pub(crate) fn table(files: &[Judged]) -> String {
    let mut text = format!("{:<28}{:<9}{:>7}", "statistic", "of", "count");
    text += &QUANTILES.map(|part| format!("{:>9}%", 100.0 * part)).concat();
    for (name, statistic) in STATISTICS {
        let values = |file: &Judged| -> Vec<f64> {
            let mut values: Vec<f64> =
                file.statistics.links.iter().filter_map(|link| statistic(link, &file.statistics)).collect();
            values.sort_by(f64::total_cmp);
            values
        };
        let links: Vec<f64> = files.iter().flat_map(values).collect();
        let medians: Vec<f64> = files
            .iter()
            .map(values)
            .filter(|values| values.len() > 1)
            .map(|values| values[(values.len() - 1) / 2])
            .collect();
        for (of, values) in [("links", links), ("medians", medians)] {
            let _ = write!(text, "\n{name:<28}{of:<9}{:>7}{}", values.len(), quantiles(values));
        }
    }
    text + "\n"
}

#[allow(dead_code)] // the tests do not call `main`
fn main() {
    let (mut files, mut refused) = (Vec::new(), 0);
    for path in std::env::args_os().skip(1) {
        match judge(Path::new(&path)) {
            // A robot with at most one link cannot be compared with others.
            Ok(file) if file.statistics.links.len() > 1 => files.push(file),
            Ok(_) => {}
            Err(_) => refused += 1,
        }
    }
    let accused = files.iter().filter(|file| !file.suspicions.is_empty()).count();
    println!("{}\n{} robots, {accused} accused; {refused} files refused", table(&files), files.len());
    for file in files.iter().filter(|file| !file.suspicions.is_empty()) {
        println!("\n{}", file.path.display());
        for suspicion in &file.suspicions {
            println!("  {suspicion}");
        }
    }
}
