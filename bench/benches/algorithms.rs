//! Every algorithm on every robot, on 1024 seeded random states in turn: `cargo bench -p bench -- talos`.

use std::time::Duration;

use bench::{MEASURED, StateTable, Task, all_robots, key};
use criterion::{Criterion, criterion_group, criterion_main};

const STATES: usize = 1024;
const SEED: u64 = 20260;

fn algorithms(criterion: &mut Criterion) {
    let robots = all_robots().unwrap_or_else(|error| panic!("{error}"));
    let tables: Vec<StateTable> =
        robots.iter().map(|model| StateTable::random(model, STATES, SEED)).collect();
    for algorithm in MEASURED {
        let mut group = criterion.benchmark_group(key(algorithm));
        for (model, states) in robots.iter().zip(&tables) {
            let mut task = Task::new(model, states);
            let mut i = 0;
            group.bench_function(model.name(), |bencher| {
                bencher.iter(|| {
                    task.call(algorithm, i);
                    i = (i + 1) % STATES;
                });
            });
        }
        group.finish();
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(50)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_secs(1));
    targets = algorithms
}
criterion_main!(benches);
