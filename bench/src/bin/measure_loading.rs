//! The time to read a robot from its file and to compile it.
//!
//! `cargo run --release -p bench --bin measure_loading -- FILE …`
//!
//! Each file is loaded 101 times, and the medians are printed. Reading makes the description and the report.
//! It opens includes and the meshes that give masses. Compiling makes the model (`Model::new`).

use std::process::ExitCode;
use std::time::Instant;

use robot_dynamics::model::Model;
use robot_dynamics::{LoadOptions, load_description};

const ROUNDS: usize = 101;

fn main() -> ExitCode {
    println!("| file | DoFs | reading \\[ms\\] | compiling \\[ms\\] | both \\[ms\\] |");
    println!("| --- | ---: | ---: | ---: | ---: |");
    for file in std::env::args().skip(1) {
        match measure(&file) {
            Ok(line) => println!("{line}"),
            Err(error) => {
                eprintln!("{file}: {error}");
                return ExitCode::FAILURE;
            }
        }
    }
    ExitCode::SUCCESS
}

fn measure(file: &str) -> Result<String, Box<dyn std::error::Error>> {
    let [mut reading, mut compiling, mut both] = [(); 3].map(|()| Vec::with_capacity(ROUNDS));
    let mut dofs = 0;
    for _ in 0..ROUNDS {
        let start = Instant::now();
        let description = load_description(file, &LoadOptions::default())?.description;
        let read = start.elapsed().as_secs_f64() * 1e3;
        let model = Model::new(description)?;
        let total = start.elapsed().as_secs_f64() * 1e3;
        dofs = model.nv();
        reading.push(read);
        compiling.push(total - read);
        both.push(total);
    }
    let [reading, compiling, both] = [reading, compiling, both].map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[ROUNDS / 2]
    });
    let name = file.rsplit('/').next().unwrap_or(file);
    Ok(format!("| {name} | {dofs} | {reading:.2} | {compiling:.2} | {both:.2} |"))
}
